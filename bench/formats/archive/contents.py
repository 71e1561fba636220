"""The files of an archive: the choice from a folder, and the names that are allowed."""

from __future__ import annotations

import re
from pathlib import Path

from bench.helpers.errors import BenchError
from bench.helpers.parsing import parse_json
from bench.storage import folder as notes
from bench.storage.store import FILE as TRIALS

SUMS = notes.SUMS
PAGE, MANIFEST = "report.html", ".report.json"  # as bench.report writes them

REQUIRED = (notes.STUDY, TRIALS, notes.ENVIRONMENT)
NOTES = (notes.DESCRIPTIONS, notes.CHECKS, notes.VERIFICATION)
"""Notes that belong in an archive. Those on one moment of one machine do not: who is writing, and the lock."""

REPORT = (
    PAGE, MANIFEST, "CONTENTS.md", "methods.md", "methods.tex", "references.bib", "answer.json", "warnings.html",
    "glossary.html",
)  # fmt: skip
"""The files of a report but its tables and figures."""

_IN_FOLDER = re.compile(r"(?:tables|figures)/[A-Za-z0-9_][A-Za-z0-9_.-]*")


def belongs(name: str) -> bool:
    """Return whether an archive may hold a payload file of this path; no such path leaves its folder."""
    return name in (*REQUIRED, *NOTES, *REPORT) or _IN_FOLDER.fullmatch(name) is not None


def report_files(folder: Path) -> list[str]:
    """Return the paths of the files that the last report in a folder wrote; none where there is no report.

    Raises:
        BenchError: where one of them is missing, is a link, or is no name of a report's file.
    """
    if not (folder / PAGE).is_file():
        return []
    again = f"write the report again: bench report {folder}"
    try:
        listed = parse_json((folder / MANIFEST).read_bytes())
    except (OSError, ValueError) as error:
        raise BenchError(f"{folder / MANIFEST}, the list of the report's files, cannot be read; {again}") from error
    names = sorted({MANIFEST, PAGE, *map(str, listed if isinstance(listed, list) else [])})
    for name in names:
        if not belongs(name) or name in REQUIRED or name in NOTES:
            raise BenchError(f"{folder / MANIFEST} lists {name!r}, which is no file of a report; {again}")
        if not (folder / name).is_file():
            raise BenchError(f"{folder / name}, a file of the report, is missing; {again}")
    return names
