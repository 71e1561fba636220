"""Note which trials are under way, so that a run that is killed leaves their names."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.helpers.parsing import parse_json
from bench.storage.committed import overwrite
from bench.trial import Trial

FILE = ".under-way"
_LINE = 1024  # bytes of the file for each job
_LONGEST = 200  # characters noted of a label


class UnderWay:
    """The file of the trials under way: a line for each job, which costs one short write a trial."""

    def __init__(self, file: int) -> None:
        self._file = file

    def begin(self, job: int, trial: Trial) -> None:
        """Note the trial that a job begins."""
        labels = trial.problem[:_LONGEST], trial.optimizer[:_LONGEST]
        with suppress(OSError):  # such as a full disk: the next commit reports it
            overwrite(self._file, job, json.dumps([*labels, trial.number]), _LINE)


@contextmanager
def noting(folder: Path) -> Iterator[UnderWay]:
    """Yield the file of a run's trials under way; it stays where the run is killed, and only there."""
    path = folder / FILE
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o644)
    except OSError as error:
        raise BenchError(f"{path} cannot be written: {error.strerror}") from error
    try:
        yield UnderWay(file)
    finally:
        os.close(file)
        path.unlink(missing_ok=True)


def left(folder: Path) -> dict[str, Any] | None:
    """Return when the last run was killed (UTC, as far as known) and its trials under way; None where it was not.

    The trials are lists of problem, optimizer and number.
    """
    try:
        lines = (folder / FILE).read_text(encoding="utf-8", errors="replace").splitlines()
        ended = datetime.fromtimestamp((folder / FILE).stat().st_mtime, UTC).isoformat(timespec="seconds")
    except OSError:
        return None
    trials = []
    for line in lines:
        with suppress(TypeError, ValueError):
            problem, optimizer, number = parse_json(line)
            trials.append([str(problem), str(optimizer), str(number)])
    return {"ended": ended, "trials": trials}
