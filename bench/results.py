"""Read a study's folder: the tidy frame, the traces and what they belong to."""

from __future__ import annotations

from functools import cache, cached_property
from os import PathLike
from typing import Any

import pandas as pd

from bench.errors import BenchError
from bench.folder import Folder
from bench.objective import Trace
from bench.problem import Problem
from bench.study import Study
from bench.trial import FRAME_COLUMNS


class Results:
    """All that a report needs of one study's folder, read once and lazily.

    Attributes:
        study: the study as frozen in the folder.
        environments: what each run that wrote here noted of its machine.
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self._folder = Folder(path)
        self.study: Study = self._folder.study()
        self.environments: list[dict[str, Any]] = self._folder.environments()
        self._problem = cache(self.study.problem)

    @cached_property
    def frame(self) -> pd.DataFrame:
        """The tidy frame: one row a trial; see :func:`load_results`."""
        problems = {entry.label: rank for rank, entry in enumerate(self.study.problems)}
        optimizers = {entry.label: rank for rank, entry in enumerate(self.study.optimizers)}
        rows = self._folder.store.rows()
        strange = ({row["problem"] for row in rows} - problems.keys()) | (
            {row["optimizer"] for row in rows} - optimizers.keys()
        )
        if strange:
            raise BenchError(
                f"{self._folder.path} holds trials of {min(strange)!r}, which its study.toml does not name; "
                "put back the study.toml that the run wrote"
            )
        rows.sort(key=lambda row: (problems[row["problem"]], optimizers[row["optimizer"]], row["trial"]))
        variables = {f"x_{name}": None for row in rows for name in row["x"]}
        figures = {name: None for row in rows for name in row["figures"]}
        table = [
            {"study": self.study.name}
            | {name: value for name, value in row.items() if name not in ("x", "figures")}
            | {f"x_{name}": value for name, value in row["x"].items()}
            | row["figures"]
            for row in rows
        ]
        return pd.DataFrame(table, columns=[*FRAME_COLUMNS, *variables, *figures])

    def traces(self, problem: str, optimizer: str) -> dict[int, Trace]:
        """Return the anytime traces of one cell by trial number."""
        return self._folder.store.traces(problem, optimizer)

    def problem(self, label: str) -> Problem:
        """Return the problem of that label, loaded once."""
        return self._problem(label)


def load_results(path: str | PathLike[str]) -> pd.DataFrame:
    """Return the tidy frame of a study's folder, one row a trial, in the study's order.

    Columns: study, problem, optimizer, trial, seed, status (ok | failed | timeout), fun, nfev, wall_s, cpu_s,
    objective_s, stop, outside_box, error, one ``x_<variable>`` per variable and one per domain figure. A failed
    trial's figures are missing values.

    Raises:
        BenchError: when the folder holds no study or no trials.
    """
    return Results(path).frame
