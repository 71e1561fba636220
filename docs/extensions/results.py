"""Run the pages whose results the site shows, as the tests run them, before Sphinx reads them.

A page that names ``/_generated/PART/PAGE/FILE`` shows a file that a page's own blocks wrote; their reports are the
site's ``examples/PAGE/report.html``.
"""

from __future__ import annotations

import hashlib
import re
import shutil
from pathlib import Path

import blocks
from sphinx.application import Sphinx
from sphinx.util import logging

LINK = re.compile(r"/_generated/((?:tutorials|how-to|reference|explanation)/[\w-]+)/")


def run_pages(app: Sphinx) -> None:
    """Run each page whose files another page shows, unless it was run before and has not changed."""
    source = Path(app.srcdir)
    shown = {name for page in blocks.PAGES for name in LINK.findall(page.read_text(encoding="utf-8"))}
    for name in sorted(shown):
        page, folder = source / f"{name}.md", source / "_generated" / name
        mark = folder / ".hash"
        digest = hashlib.sha256(page.read_bytes()).hexdigest()
        if mark.exists() and mark.read_text() == digest:
            continue
        logging.getLogger(__name__).info("running the blocks of %s", page.name)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        blocks.run(page, folder)
        for report in folder.glob("results/runs/*/report.html"):  # with the files that it links
            copy = source / "_generated" / "site" / "examples" / page.stem
            shutil.rmtree(copy, ignore_errors=True)
            shutil.copytree(report.parent, copy, ignore=shutil.ignore_patterns(".*"))
        mark.write_text(digest)


def setup(app: Sphinx) -> dict[str, bool]:
    """Run the pages when the build begins."""
    app.connect("builder-inited", run_pages)
    return {"parallel_read_safe": True}
