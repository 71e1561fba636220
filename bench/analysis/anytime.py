"""Best-so-far values over evaluations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.objective import Trace


def evaluation_grid(budget: int, points: int = 60) -> NDArray[np.int64]:
    """Return increasing evaluation counts from 1 to the budget, spaced evenly on a log axis."""
    return np.unique(np.geomspace(1, budget, points).round().astype(np.int64))


def best_so_far(traces: Sequence[Trace], evaluations: NDArray[np.int64], failed: int = 0) -> pd.DataFrame:
    """Return evaluations, median, q1 and q3 of the best value found so far, over the trials of one cell.

    A trial that ended early keeps its last value; ``failed`` trials, which left no trace, count as +inf throughout.
    Quartiles are upper order statistics wherever a value is still infinite. No row for a cell without trials.
    """
    if not len(traces) + failed:
        return pd.DataFrame(columns=["evaluations", "median", "q1", "q3"], dtype=float)
    values = np.full((len(traces) + failed, len(evaluations)), np.inf)
    for row, trace in zip(values, traces, strict=False):
        row[:] = trace.at(evaluations)
    quartiles = np.quantile(values, [0.25, 0.5, 0.75], axis=0, method="higher")
    whole = np.isfinite(values).all(axis=0)
    quartiles[:, whole] = np.quantile(values[:, whole], [0.25, 0.5, 0.75], axis=0)
    q1, median, q3 = quartiles
    return pd.DataFrame({"evaluations": evaluations, "median": median, "q1": q1, "q3": q3})
