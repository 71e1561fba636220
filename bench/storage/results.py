"""Read one study's folder, or several to compare: tidy frame, traces, study and environments."""

from __future__ import annotations

import dataclasses
import math
from functools import cache, cached_property
from os import PathLike
from pathlib import Path

import pandas as pd

from bench.errors import BenchError
from bench.objective import Trace
from bench.problem import Problem
from bench.storage.folder import Folder
from bench.storage.frame import tidy
from bench.storage.sources import agreed, read_sources, united

AnyPath = str | PathLike[str]


@dataclasses.dataclass(frozen=True)
class ProblemFacts:
    """The facts of a problem that results are measured against, as far as it can be loaded where they are read.

    Attributes:
        optimum: its best known objective value, or None.
        expected: the true value of domain metrics and the tolerance around it, by name.
        box: the bounds of each search variable, by name.
        reason: why the problem cannot be loaded, so that no fact is known; "" where it can.
    """

    optimum: float | None = None
    expected: dict[str, tuple[float, float]] = dataclasses.field(default_factory=dict)
    box: dict[str, tuple[float, float]] = dataclasses.field(default_factory=dict)
    reason: str = ""


class Results:
    """The contents of a study's folder, or of several that can be compared, read lazily and once.

    Several folders make one study of all their problems and optimizers. An optimizer's label that occurs in several
    folders gets the folder's name, as in ``"gwo (old)"``.

    Attributes:
        names: the folders' names, with as many parents as make them distinct.
        study: the study as frozen in the folder; for several folders, all their problems and optimizers.
        environments: one record for each run on each machine (:mod:`bench.storage.provenance`).
        checks: the verdicts of ``bench check`` by optimizer label; empty where it has not run.
        verifications: the note of ``bench verify`` in each folder, empty where it has not run.
        fingerprints: the hash of each problem's data when it ran, by label; "" where its name determines the data.

    Raises:
        BenchError: when a folder holds no study, or the folders differ in budget or in what a problem's label means.
    """

    def __init__(self, path: AnyPath, *others: AnyPath) -> None:
        self._sources = read_sources([Folder(each) for each in (path, *others)])
        self.names = [source.name for source in self._sources]
        self.study = united([source.study for source in self._sources])
        self.environments = [record for source in self._sources for record in source.environments]
        self.fingerprints = agreed([source.folder.fingerprints().data for source in self._sources], self.paths)
        self.checks = {
            source.shown[label]: noted
            for source in self._sources
            for label, noted in source.folder.checks().items()
            if label in source.shown
        }
        self.verifications = [source.folder.verification() for source in self._sources]
        self._problem = cache(self.study.problem)
        self._facts = cache(self._look_up)

    def __repr__(self) -> str:
        return f"Results({', '.join(repr(str(path)) for path in self.paths)})"

    @property
    def paths(self) -> list[Path]:
        """The folders, in the order given."""
        return [source.folder.path for source in self._sources]

    @cached_property
    def frame(self) -> pd.DataFrame:
        """The tidy frame: one row a trial; see :func:`load_results`."""
        return self._rows.drop(columns="environment")

    @property
    def origins(self) -> pd.Series:
        """The number (from 1) of the environment of each row of the frame; not a column, as it is no result."""
        return self._rows["environment"]

    @cached_property
    def _rows(self) -> pd.DataFrame:
        return tidy(
            (row for source in self._sources for row in source.rows()),
            [entry.label for entry in self.study.problems],
            [entry.label for entry in self.study.optimizers],
        )

    @cached_property
    def traces(self) -> dict[tuple[str, str, int], Trace]:
        """The anytime traces by (problem, optimizer, trial); failed trials have none."""
        return {
            (problem, source.shown[optimizer], trial): trace
            for source in self._sources
            for (problem, optimizer, trial), trace in source.folder.store.traces().items()
        }

    def problem(self, label: str) -> Problem:
        """Return the problem of that label, loaded once; raises BenchError when it is not the problem that was run.

        Its data may have changed since, or its plug-in may be missing on the machine that reads the results.
        """
        problem = self._problem(label)
        if self.fingerprints.get(label, "") not in ("", problem.fingerprint()):
            raise BenchError(f"the data of problem {label!r} is no longer what the trials were made with")
        return problem

    def facts(self, label: str) -> ProblemFacts:
        """Return the facts of the problem of that label, as it loads on this machine; never raises."""
        return self._facts(label)

    def _look_up(self, label: str) -> ProblemFacts:
        try:
            problem = self.problem(label)
            optimum = None if problem.optimum is None else float(problem.optimum)
            if optimum is not None and not math.isfinite(optimum):
                raise ValueError(f"its optimum is {optimum}")
            expected = {str(name): (float(true), float(near)) for name, (true, near) in problem.expected.items()}
            box = zip(map(float, problem.lower), map(float, problem.upper), strict=True)
            return ProblemFacts(optimum, expected, dict(zip(problem.variables, box, strict=True)))
        except BenchError as error:
            return ProblemFacts(reason=str(error))
        except Exception as error:  # a plug-in may raise anything
            return ProblemFacts(reason=f"{type(error).__name__}: {error}")


def load_results(path: AnyPath, *others: AnyPath) -> pd.DataFrame:
    """Return the tidy frame of a study's folder, one row a trial, in the study's order; or all rows of several folders.

    Columns: study, problem, optimizer, trial, seed, status (ok | failed | timeout), fun, nfev, wall_s, cpu_s,
    objective_s, stop, outside_box, error, one ``x_<variable>`` per variable and one per domain metric. A failed
    trial's metrics are missing values.

    Raises:
        BenchError: when a folder holds no study or no trials, or the folders cannot be compared (:class:`Results`).
    """
    return Results(path, *others).frame
