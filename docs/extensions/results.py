"""Run the pages that readers repeat, and show below each block what it printed.

A page that names ``/_generated/PART/PAGE/FILE`` shows a file that a page's own blocks wrote; the reports that a page
wrote are the site's ``examples/PAGE/RUN/report.html`` where any page shows one of them, other pages of its folder the
site's ``examples/PAGE/FILE.html``.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import textwrap
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import blocks
from sphinx.application import Sphinx
from sphinx.util import logging

logger = logging.getLogger(__name__)
LINK = re.compile(r"/_generated/((?:tutorials|how-to|reference/api|reference|explanation)/[\w-]+)/")
REPORT = re.compile(r"(?:examples/|\{report\} )([\w-]+)/")
REPEATED = ("", "tutorials", "how-to")  # the parts of the site all of whose pages are run
MOST_LINES = 60  # of what a block printed
PAGE_WIDTH, TERMINAL = 88, 80  # characters that a line of it has on a page, and to which a longer one is broken
PROGRESS = re.compile(r"\d[\d,]* of [\d,]+ runs done(, about .* left)?")  # the pace of the build's own machine


def run_pages(app: Sphinx) -> None:
    """Run each page of these parts, or whose files another page shows, unless it has run as it is; two at a time.

    A page that fails is a warning, so that one build names all of them.
    """
    source = Path(app.srcdir)
    texts = [page.read_text(encoding="utf-8") for page in blocks.PAGES]
    pages = {source / f"{name}.md" for text in texts for name in LINK.findall(text)}
    pages |= {page for part in REPEATED for page in (source / part).glob("*.md") if blocks.runnable(page)}
    shown = {name for text in texts for name in REPORT.findall(text)}
    stale = [page for page in sorted(pages) if not blocks.has_run(page)]
    with ProcessPoolExecutor(2, get_context("spawn"), max_tasks_per_child=1) as pool:
        for page, (fault, seconds) in zip(stale, pool.map(tried, stale), strict=True):
            logger.info("ran the blocks of %s in %.0f s of processor time", page.relative_to(source), seconds)
            if fault:
                logger.warning("%s", fault)
            shutil.rmtree(site_of(page), ignore_errors=True)
    for page in sorted(pages):
        if page.stem in shown and not site_of(page).exists():
            publish(blocks.folder_of(page), site_of(page))


def tried(page: Path) -> tuple[str, float]:
    """Run a page anew in this process, begun for it; return its first fault, "" for none, and the processor seconds."""
    fault = ""
    try:
        blocks.run_anew(page)
    except blocks.BlockError as error:
        fault = str(error)
    return fault, sum(os.times()[:4])


def site_of(page: Path) -> Path:
    """Return the folder of the site that has the reports of a page."""
    return blocks.DOCS / "_generated" / "site" / "examples" / page.stem


def publish(folder: Path, site: Path) -> None:
    """Copy the reports of a page with the files that they link, and its other pages of HTML, into the site."""
    for report in folder.glob("results/runs/*/report.html"):
        unlinked = shutil.ignore_patterns(".*", "*.sqlite", "committed.json")
        shutil.copytree(report.parent, site / report.parent.name, ignore=unlinked)
    for page in folder.glob("*.html"):
        site.mkdir(parents=True, exist_ok=True)
        shutil.copy(page, site)


def show_printed(app: Sphinx, name: str, text: list[str]) -> None:
    """Add to a page, below each block whose output it does not have itself, what the block printed."""
    file = Path(app.srcdir) / "_generated" / name / ".printed.json"
    if not file.exists():
        return
    lines, found = text[0].split("\n"), blocks.blocks(Path(app.srcdir) / f"{name}.md")
    for number, printed in reversed(json.loads(file.read_text(encoding="utf-8")).items()):
        lines_printed = [line.rstrip() for line in printed.strip("\n").splitlines()]
        shown = [line for line in lines_printed if not PROGRESS.fullmatch(line)]
        shown = [*shown[:MOST_LINES], "…"] if len(shown) > MOST_LINES else shown
        shown = [part for line in shown for part in broken(line)]
        at = found[int(number)].last
        lines[at:at] = ["", "~~~~{code-block} text", ":class: printed", "", *shown, "~~~~", ""]
    text[0] = "\n".join(lines)


def broken(line: str) -> list[str]:
    """Return the parts of a printed line that is wider than a page, broken between words as a terminal breaks it."""
    if len(line) <= PAGE_WIDTH:
        return [line]
    indent = line[: len(line) - len(line.lstrip())] + 4 * " "
    return textwrap.wrap(line, TERMINAL, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def setup(app: Sphinx) -> dict[str, bool]:
    """Run the pages when the build begins."""
    app.connect("builder-inited", run_pages)
    app.connect("source-read", show_printed)
    return {"parallel_read_safe": True}
