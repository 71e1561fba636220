"""Have the trials of one candidate after the other made in processes that stay warm, and that no candidate enters."""

from __future__ import annotations

import ast
import re
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from os import PathLike
from pathlib import Path
from threading import local
from typing import Self

from joblib import effective_n_jobs

from bench.execution.job import Task
from bench.execution.supervisor import KilledError, Supervisor, failed
from bench.helpers.errors import explained
from bench.plugins import objects
from bench.plugins.from_file import SOURCE, located
from bench.plugins.loading import OBJECT, OptimizerLike
from bench.plugins.packing import Objects
from bench.trial.columns import Row
from bench.trial.trial import Trial

LABEL = "candidate"
NAME = f"{OBJECT}{LABEL}"
KEY = f"optimizers {NAME}"
PARSED = 50_000  # characters of a source that is worth parsing here, before any process is started for it

STAND_IN = """
import scipy.linalg, scipy.optimize, scipy.spatial.distance, scipy.special, scipy.stats

def search(objective, rng):
    while True:
        objective(objective.initial(10))
"""
"""What the processes load and warm up in the place of candidates; what these often import takes no time of theirs."""

Source = OptimizerLike | PathLike[str]
"""A candidate: Python source, a path to a file of it, or an optimizer, a class or a function."""


@dataclass
class Candidate:
    """A candidate on its way through its trials; the others are left out once one has failed."""

    held: Objects  # what its name stands for; empty of baselines, which are installed
    text: str = ""  # its source, if it has one
    error: str = ""

    @classmethod
    def read(cls, source: Source) -> Self:
        """Return a candidate, which is not run here."""
        if isinstance(source, PathLike) or (isinstance(source, str) and "\n" not in source and source.endswith(".py")):
            with explained(f"the candidate {source} cannot be read", (OSError, ValueError)):
                source = Path(source).read_text(encoding="utf-8")
        candidate = cls({KEY: objects.packed(source)}, source if isinstance(source, str) else "")
        if len(candidate.text) <= PARSED:
            with warnings.catch_warnings(action="ignore"), suppress(ValueError, RecursionError, MemoryError):
                try:
                    ast.parse(candidate.text, SOURCE)
                except SyntaxError as error:
                    candidate.error = located(error)
        return candidate

    @property
    def reason(self) -> str:
        """The error, with the text of the line that is at fault."""
        error = self.error.partition("\n")[0].removesuffix(" (--timeout)").removesuffix(" (--memory)")
        lines, found = self.text.splitlines(), re.match(r"line (\d{1,7}): ", error)
        at_fault = found and lines[int(found[1]) - 1 : int(found[1])]
        return f"{error} ({at_fault[0].strip()[:100]})" if at_fault else error


class Workers:
    """Threads that have trials made, each by a supervisor of its own.

    Threads, as a sandbox ends with the thread that has started it: those of joblib end with every call.
    """

    def __init__(self, task: Task, n_jobs: int) -> None:
        self._task, self._local, self._supervisors = task, local(), list[Supervisor]()
        self._threads = ThreadPoolExecutor(effective_n_jobs(n_jobs), "evaluator", self._begin)

    def rows(self, candidates: Sequence[Candidate], trials: Sequence[Trial]) -> Iterator[Row]:
        """Yield the rows of the trials of each candidate; of one that has failed, none is made any more."""
        return self._threads.map(self._row, *zip(*product(candidates, trials), strict=True))

    def close(self) -> None:
        """End all processes and threads."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for supervisor in self._supervisors:
            supervisor.kill()

    def _begin(self) -> None:
        self._local.supervisor = Supervisor(self._task)
        self._supervisors.append(self._local.supervisor)

    def _row(self, candidate: Candidate, trial: Trial) -> Row:
        if candidate.error:
            return failed("left out, as the candidate has failed")
        try:
            row: Row = self._local.supervisor.make(trial, candidate.held)
        except KilledError:
            row = failed("the evaluator was closed")
        if row["status"] != "ok" and not candidate.error:
            candidate.error = str(row["error"])
        return row
