"""The directive ``report``: a report that the build wrote, as a link under its picture, light and dark.

``{report} gallery/thesis`` is what a block of gallery.md wrote: the report of the run ``thesis``, or a page such as
``gallery/wear.html``. The option ``part`` takes the picture of one part of it, by its id. The system's Chromium takes
the pictures; where there is none, a link stands alone.
"""

from __future__ import annotations

import shutil
from functools import cache
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective
from sphinx.util.osutil import relative_uri

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
WIDTH, HEIGHT = 1100, 700  # of a picture, at most


class Report(SphinxDirective):
    """``{report} PAGE/RUN`` with options ``alt`` and ``part``; the content is the caption."""

    required_arguments = 1
    has_content = True
    option_spec = {"alt": directives.unchanged_required, "part": directives.unchanged}  # noqa: RUF012  (docutils')

    def run(self) -> list[nodes.Node]:
        """Return both pictures and the caption, all of them links to the report."""
        name, part = self.arguments[0], self.options.get("part", "")
        path = f"examples/{name}" + ("" if name.endswith(".html") else "/report.html")
        report = Path(self.env.srcdir) / "_generated" / "site" / path
        if not report.exists():
            raise self.error(f"no block of a page wrote {report}")
        address = relative_uri(self.env.app.builder.get_target_uri(self.env.docname), path)
        address += f"#{part}" if part else ""
        caption = "\n".join(self.content) or "The whole report"
        size = f"{report.stat().st_size / 1e6:.1f} MB"
        pictures = "\n".join(
            f":::{{image}} /{picture.relative_to(self.env.srcdir)}\n:alt: {self.options['alt']}\n"
            f":class: only-{mode} report-picture\n:::\n"
            for mode, picture in taken(self.env.srcdir, report, part).items()
        )
        link = f'<a class="report-link" href="{address}">{caption}</a> ({size})'
        found = self.parse_text_to_nodes(f"{pictures}\n\n{link}")
        for image in (image for node in found for image in node.findall(nodes.image)):
            image.replace_self(nodes.reference("", "", image.deepcopy(), refuri=address))
        return found


def taken(source: Path, report: Path, part: str) -> dict[str, Path]:
    """Return the pictures of a report or of a part of it, by mode; none without a browser."""
    folder = Path(source) / "_generated" / "pictures"
    folder.mkdir(parents=True, exist_ok=True)
    stem = f"{report.parent.parent.name}-{report.parent.name}-{report.stem}{'-' + part if part else ''}"
    pictures = {mode: folder / f"{stem.replace('.', '-')}-{mode}.png" for mode in ("light", "dark")}
    stale = [mode for mode, path in pictures.items() if not _newer(path, report)]
    if stale and browser() is None:
        return {}
    for mode in stale:
        _take(report, part, mode, pictures[mode])
    return pictures


def _newer(path: Path, report: Path) -> bool:
    return path.exists() and path.stat().st_mtime >= report.stat().st_mtime


def _take(report: Path, part: str, mode: str, path: Path) -> None:
    page = browser().new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme=mode)
    page.goto(report.as_uri() + (f"#{part}" if part else ""))
    page.wait_for_load_state("networkidle")
    clip = None
    if part:
        page.evaluate(
            "(id) => { for (let at = document.getElementById(id); at; at = at.parentElement) at.open = true }", part
        )
        page.wait_for_timeout(300)
        box = page.locator(f'[id="{part}"]').bounding_box()
        assert box, f"{report} has no part {part}"
        top = box["y"] + page.evaluate("scrollY")
        clip = {"x": 0, "y": top, "width": WIDTH, "height": min(box["height"], HEIGHT)}
    page.screenshot(path=path, clip=clip, full_page=bool(part))
    page.close()


@cache
def browser() -> Any:
    """Return a running Chromium; None where there is none, or no playwright."""
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        program = None
    if program is None:
        logging.getLogger(__name__).info("no pictures of reports: no Chromium, or no playwright")
        return None
    return (
        sync_playwright().start().chromium.launch(executable_path=program, args=["--no-sandbox", "--hide-scrollbars"])
    )


def close(app: Sphinx, error: Exception | None) -> None:
    """End the browser."""
    del app, error
    if browser.cache_info().currsize and browser() is not None:
        browser().close()
        browser.cache_clear()


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("report", Report)
    app.connect("build-finished", close)
    return {"parallel_read_safe": False}
