"""Count what a reader of a page gets: words opened, words in the file, bytes and files."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

SILENT = ("script", "style", "svg", "title")
UNOPENED = ("folded", "data", "files", "long")  # classes of folds behind a picture or a table


class _Words(HTMLParser):
    """Counts words outside of scripts and pictures, and those outside of folds within a section."""

    def __init__(self) -> None:
        super().__init__()
        self.opened = self.all = 0
        self._silent: list[str] = []
        self._folds: list[bool] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in SILENT:
            self._silent.append(tag)
        if tag == "details":
            classes = (dict(attrs).get("class") or "").split()
            self._folds.append(bool({*classes} & {*UNOPENED}))

    def handle_endtag(self, tag: str) -> None:
        if self._silent and self._silent[-1] == tag:
            self._silent.pop()
        if tag == "details":
            self._folds.pop()

    def handle_data(self, data: str) -> None:
        words = 0 if self._silent else len(re.findall(r"\S+", data))
        self.all += words
        self.opened += words * (not any(self._folds))


def size(folder: Path) -> dict[str, int]:
    """Return the words of a report's page that are opened and in the file, its bytes, and the files of the folder."""
    page, words = folder / "report.html", _Words()
    words.feed(page.read_text(encoding="utf-8"))
    files = sum(path.is_file() for path in folder.rglob("*"))
    return {"opened": words.opened, "words": words.all, "bytes": page.stat().st_size, "files": files}
