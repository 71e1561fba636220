"""Best-so-far values over evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis.cells import Traces, labels
from bench.objective import Trace

CURVE = ("evaluations", "median", "q1", "q3")


def evaluation_grid(budget: int, points: int = 60) -> NDArray[np.int64]:
    """Return increasing evaluation counts from 1 to the budget, spaced evenly on a log axis."""
    return np.unique(np.geomspace(1, budget, points).round().astype(np.int64))


def best_so_far(traces: Sequence[Trace], evaluations: NDArray[np.int64], failed: int = 0) -> pd.DataFrame:
    """Return evaluations, median, q1 and q3 of the best value found so far, over the trials of one cell.

    A trial that ended early keeps its last value; ``failed`` trials, which left no trace, count as +inf throughout.
    Quartiles are upper order statistics wherever a value is still infinite. No row for a cell without trials.
    """
    if not len(traces) + failed:
        return pd.DataFrame(columns=list(CURVE), dtype=float)
    values = np.full((len(traces) + failed, len(evaluations)), np.inf)
    for row, trace in zip(values, traces, strict=False):
        row[:] = trace.at(evaluations)
    quartiles = np.quantile(values, [0.25, 0.5, 0.75], axis=0, method="higher")
    whole = np.isfinite(values).all(axis=0)
    quartiles[:, whole] = np.quantile(values[:, whole], [0.25, 0.5, 0.75], axis=0)
    q1, median, q3 = quartiles
    return pd.DataFrame({"evaluations": evaluations, "median": median, "q1": q1, "q3": q3})


def convergence(frame: pd.DataFrame, traces: Traces, evaluations: NDArray[np.int64]) -> pd.DataFrame:
    """Return the :func:`best_so_far` of every cell: problem, optimizer, evaluations, median, q1 and q3.

    A failed trial counts as +inf, and so does one without a trace. No rows for a cell without trials.

    Args:
        frame: the tidy frame.
        traces: by (problem, optimizer, trial).
        evaluations: the counts to look at, such as an :func:`evaluation_grid`.
    """
    found: dict[tuple[str, str], list[Trace | None]] = {}
    for problem, optimizer, trial, status in zip(
        frame["problem"], frame["optimizer"], frame["trial"], frame["status"], strict=True
    ):
        trace = traces.get((problem, optimizer, trial)) if status == "ok" else None
        found.setdefault((problem, optimizer), []).append(trace)
    curves = []
    for problem, optimizer in product(labels(frame, "problem"), labels(frame, "optimizer")):
        if trials := found.get((problem, optimizer)):
            known = [trace for trace in trials if trace is not None]
            curve = best_so_far(known, evaluations, failed=len(trials) - len(known))
            curves.append(curve.assign(problem=problem, optimizer=optimizer))
    columns = ["problem", "optimizer", *CURVE]
    return pd.concat(curves, ignore_index=True)[columns] if curves else pd.DataFrame(columns=columns)
