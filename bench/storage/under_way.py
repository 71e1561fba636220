"""Note the process that writes to a folder and its trials under way, so that a killed run leaves their names."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from bench.helpers.errors import explained
from bench.helpers.parsing import JsonObject, parse_json
from bench.storage.committed import overwrite
from bench.trial.trial import Trial

FILE = ".under-way"
_LINE = 1024  # bytes of each line
_LONGEST = 200  # characters noted of a label


class UnderWay:
    """The file of a run: a line for its process, and one for the trial of each job, which costs one short write."""

    def __init__(self, file: int) -> None:
        self._file = file

    def begin(self, job: int, trial: Trial) -> None:
        """Note the trial that a job begins."""
        labels = trial.problem[:_LONGEST], trial.optimizer[:_LONGEST]
        with suppress(OSError):  # such as a full disk: the next commit reports it
            overwrite(self._file, 1 + job, json.dumps([*labels, trial.number]), _LINE)


@contextmanager
def noting(folder: Path, holder: JsonObject) -> Iterator[UnderWay]:
    """Yield the file of a run by the process ``holder``; its content stays where the run is killed, and only there."""
    path = folder / FILE
    with explained(f"{path} cannot be written"):
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o644)
    try:
        with suppress(OSError):
            overwrite(file, 0, json.dumps(holder), _LINE)
        yield UnderWay(file)
    finally:
        with suppress(OSError):  # where the folder has become read-only, the empty file stays
            os.ftruncate(file, 0)
        os.close(file)
        with suppress(OSError):
            path.unlink(missing_ok=True)


def holder(folder: Path) -> JsonObject:
    """Return the process that has begun to write here, as :func:`noting` was given it; empty where none is known."""
    with suppress(OSError, IndexError, ValueError):
        noted = parse_json(_lines(folder)[0])
        return noted if isinstance(noted, dict) else {}
    return {}


def left(folder: Path) -> JsonObject:
    """Return when the last run was ``ended`` (UTC, as far as known) and its ``trials`` under way, none without a note.

    The trials are lists of problem, optimizer and number.
    """
    ended, trials = "", []
    with suppress(OSError):
        ended = datetime.fromtimestamp((folder / FILE).stat().st_mtime, UTC).isoformat(timespec="seconds")
        for line in _lines(folder)[1:]:
            with suppress(TypeError, ValueError):
                problem, optimizer, number = parse_json(line)
                trials.append([str(problem), str(optimizer), str(number)])
    return {"ended": ended, "trials": trials}


def _lines(folder: Path) -> list[str]:
    return (folder / FILE).read_text(encoding="utf-8", errors="replace").splitlines()
