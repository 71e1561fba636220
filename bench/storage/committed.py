"""Note beside a store how much was committed to it.

SQLite passes over commits that it cannot read in a damaged write-ahead log, and takes an emptied file for a new store.
The note, which is written after each commit, shows that commits are lost. A kill between the two leaves a note that
lags behind the store, never one that is ahead of it.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import NamedTuple

from bench.helpers.errors import explained
from bench.helpers.parsing import parse_json

FILE = "committed.json"
_LENGTH = 64  # bytes, always: the note is overwritten in place, which costs one short write a commit


class Committed(NamedTuple):
    """The number of commits to a store, and of the trials that it then held."""

    commits: int = 0
    trials: int = 0


def read(folder: Path) -> Committed:
    """Return the last note; an empty one where the note is missing or damaged."""
    try:
        noted = parse_json((folder / FILE).read_bytes())
        return Committed(int(noted["commits"]), int(noted["trials"]))
    except (OSError, KeyError, TypeError, ValueError):
        return Committed()


def write(folder: Path, committed: Committed) -> None:
    """Replace the note; raises BenchError where it cannot be written."""
    path = folder / FILE
    with explained(f"{path} cannot be written"):
        file = os.open(path, os.O_WRONLY | os.O_CREAT, 0o644)
        try:
            overwrite(file, 0, json.dumps(committed._asdict()), _LENGTH)
        finally:
            os.close(file)


def overwrite(file: int, line: int, text: str, length: int) -> None:
    """Write a line of an open file whose lines all have ``length`` bytes; a longer text is cut."""
    os.lseek(file, line * length, os.SEEK_SET)
    os.write(file, text.encode()[: length - 1].ljust(length - 1) + b"\n")
