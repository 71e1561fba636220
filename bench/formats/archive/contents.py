"""The files of an archive: the choice from a folder, a description of each, and the names that are allowed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from bench.errors import BenchError
from bench.helpers.parsing import parse_json
from bench.storage import folder as notes
from bench.storage.store import FILE as TRIALS

CRATE = notes.CRATE
SUMS = "SHA256SUMS"
PAGE, MANIFEST = "report.html", ".report.json"  # as bench.report writes them

REQUIRED = (notes.STUDY, TRIALS, notes.ENVIRONMENT)
NOTES = (notes.DESCRIPTIONS, notes.CHECKS, notes.VERIFICATION, notes.KILLED)
"""Notes that belong in an archive. Those on one moment of one machine do not: when the store was last checked, who is
writing, and the lock."""

DESCRIPTIONS = {
    notes.STUDY: ("The frozen study", "Problems, optimizers, trials, budget and seed; 'bench run' repeats the study."),
    TRIALS: ("The trials", "SQLite: one row a trial in the view 'trials', points, anytime traces, and digests."),
    notes.ENVIRONMENT: (
        "The environments", "Versions, machine, commit, command, and hashes of study and data of every run.",
    ),
    notes.DESCRIPTIONS: ("Optimizers", "How the plug-ins described the optimizers: works, parameters and defaults."),
    notes.CHECKS: ("Checks of the optimizers", "What 'bench check' found: the contract, and biases."),
    notes.VERIFICATION: ("Verification", "What 'bench verify' found when it made trials again."),
    notes.KILLED: ("Runs that were killed", "When each ended, and the trials then under way."),
    PAGE: ("The report", "Statistics, tables and figures on one page that works offline."),
    MANIFEST: ("The files of the report", "A list, by which the next report removes those that it does not write."),
    "CONTENTS.md": ("Contents of the report", "A line for each table and figure in all its formats."),
    "methods.md": ("The methods", "As Markdown, for a paper."),
    "methods.tex": ("The methods", "As LaTeX, for a paper."),
    "references.bib": ("References", "The works that the methods cite, as BibTeX."),
    "answer.json": ("The answer", "The first sentence of the verdict, and a short table of the optimizers."),
}  # fmt: skip
FOLDERS = {"tables": "Table of the report", "figures": "Figure of the report"}

MEDIA_TYPES = {
    ".bib": "application/x-bibtex", ".csv": "text/csv", ".html": "text/html", ".json": "application/json",
    ".md": "text/markdown", ".pdf": "application/pdf", ".py": "text/x-python", ".sqlite": "application/vnd.sqlite3",
    ".svg": "image/svg+xml", ".tex": "application/x-tex", ".toml": "application/toml",
}  # fmt: skip
"""The media type of a file, by the end of its name."""

_IN_FOLDER = re.compile(rf"(?:{'|'.join(FOLDERS)})/[A-Za-z0-9_][A-Za-z0-9_.-]*")


@dataclass(frozen=True)
class PackedFile:
    """A file of an archive: its path in it, its size in bytes, and its SHA-256 in hexadecimal digits."""

    name: str
    size: int
    sha256: str

    @property
    def media_type(self) -> str:
        """The media type, by the end of the name."""
        return MEDIA_TYPES.get(PurePosixPath(self.name).suffix, "application/octet-stream")

    @property
    def about(self) -> tuple[str, str]:
        """A title and one sentence that describe the file."""
        if self.name in DESCRIPTIONS:
            return DESCRIPTIONS[self.name]
        title = FOLDERS.get(self.name.partition("/")[0], "File")
        return f"{title}: {PurePosixPath(self.name).stem}", f"{title} as {self.media_type}."


def belongs(name: str) -> bool:
    """Return whether an archive may hold a payload file of this path; no such path leaves its folder."""
    return name in DESCRIPTIONS or _IN_FOLDER.fullmatch(name) is not None


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
