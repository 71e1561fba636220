"""The evidence that the integrity checks look at, and the findings that they return."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis.cells import Traces, variables
from bench.analysis.timing import timing
from bench.analysis.traits import percent
from bench.objective import Trace
from bench.problem import Floats

ON_BOUND = 1e-12  # of the box's width: a clipped point that is scaled back is rounded
NAMED = 5  # names in a sentence; the column ``cells`` holds all

Verdict = Literal["pass", "note", "warning", "error", "not checked"]
Boxes = Mapping[str, Mapping[str, tuple[float, float]]]
Diagnoses = Mapping[str, Sequence[Mapping[str, Any]]]
CELL = ["problem", "optimizer"]


class Finding(NamedTuple):
    """The result of one check: its verdict, one or two short sentences, and the cells concerned."""

    verdict: Verdict
    text: str
    cells: Sequence[str] = ()


EMPTY = Trace(np.empty(0, dtype=np.int64), np.empty(0))


@dataclass(frozen=True)
class Evidence:
    """The data that the checks look at; see :func:`bench.analysis.integrity.integrity`."""

    frame: pd.DataFrame
    budget: int
    planned: int
    traces: Traces
    boxes: Boxes
    diagnoses: Diagnoses
    verifications: Sequence[Mapping[str, Any]]

    @cached_property
    def finished(self) -> pd.DataFrame:
        """The trials that finished, with problem and optimizer as plain labels."""
        finished = self.frame[self.frame["status"] == "ok"]
        return finished.astype(dict.fromkeys(CELL, object)).reset_index(drop=True)

    @property
    def variables(self) -> list[str]:
        """The columns of the final points."""
        return variables(self.frame)

    @cached_property
    def times(self) -> pd.DataFrame:
        """The times of trials, by optimizer."""
        return timing(self.frame)

    def traces_of(self, trials: pd.DataFrame) -> list[Trace]:
        """Return the trace of each trial, an empty one where there is none."""
        keys = zip(trials["problem"], trials["optimizer"], trials["trial"], strict=True)
        return [self.traces.get(key, EMPTY) for key in keys]


Check = Callable[[Evidence], Finding]


def judge(
    trials: pd.DataFrame, bad: NDArray[np.bool_], verdict: Verdict, did: str, meaning: str = "", *, well: str
) -> Finding:
    """Return a finding on what the ``bad`` trials ``did``, where, and what it means, or a pass if no trial is bad."""
    if not bad.any():
        return Finding("pass", well)
    text = f"{bad.sum():,} of {len(trials):,} trials {did}, in {where(trials[bad])}. {meaning}"
    return Finding(verdict, text.strip(), cell_names(trials[bad]))


def cell_names(rows: pd.DataFrame) -> list[str]:
    """Return the cells of the rows, each as "optimizer on problem"."""
    pairs = rows[["optimizer", "problem"]].astype(object).drop_duplicates()
    return [f"{optimizer} on {problem}" for optimizer, problem in pairs.to_numpy()]


def where(rows: pd.DataFrame) -> str:
    """Return the cells of the rows in short: "a on p, b on 18 problems"."""
    problems = rows.astype(dict.fromkeys(CELL, object)).groupby("optimizer", sort=False)["problem"].unique()
    return enumerated(
        [f"{o} on {each[0] if len(each) == 1 else f'{len(each):,} problems'}" for o, each in problems.items()]
    )


def floats(trials: pd.DataFrame, column: str) -> Floats:
    """Return a column as float64, NaN for what is no number."""
    return pd.to_numeric(trials[column], errors="coerce").to_numpy(dtype=float)


def enumerated(names: Sequence[str]) -> str:
    """Return the names with commas, shortened to the first five and the number of the others."""
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def percentages(shares: pd.Series[float]) -> str:
    """Return shares as "a 1%, b 2.5%"."""
    return enumerated([f"{name} {percent(share)}" for name, share in shares.items()])


def on_bound(trials: pd.DataFrame, boxes: Boxes) -> pd.DataFrame:
    """Return 1 or 0 for each trial and variable, NaN where the trial's problem has no such variable or no known box."""
    table = pd.DataFrame(index=trials.index)
    for name in dict.fromkeys(name for box in boxes.values() for name in box):
        if f"x_{name}" in trials:
            ends = [boxes.get(problem, {}).get(name, (np.nan, np.nan)) for problem in trials["problem"]]
            lower, upper = np.array(ends, dtype=float).T
            x, near = floats(trials, f"x_{name}"), ON_BOUND * (upper - lower)
            table[name] = np.where(np.isnan(x - lower), np.nan, (x <= lower + near) | (x >= upper - near))
    return table
