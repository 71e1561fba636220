"""How often, and how soon, the trials on constrained problems found a feasible point."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pandas as pd

from bench.analysis.cells import Traces, cells, traces_of


def feasibility(frame: pd.DataFrame, traces: Traces, problems: Collection[str]) -> pd.DataFrame:
    """Return how many trials of each cell found a feasible point, and after how many evaluations.

    A trial on a constrained problem records feasible points only (:mod:`bench.trial.scoring.constraints`): it found one
    where its value is finite, first at the first evaluation of its trace. A failed trial counts as one without.

    Args:
        frame: the tidy frame.
        traces: of its trials.
        problems: the labels of the constrained problems.

    Returns:
        One row a cell with columns problem, optimizer, trials, feasible (trials), rate (their share, NaN without a
        trial), first (the median evaluation, from 1, of the first feasible point; +inf where at least half of the
        trials found none, NaN without a trial).
    """
    rows, frame = [], frame[frame["problem"].isin(problems)]
    firsts = [np.append(trace.evaluations, np.inf)[0] for trace in traces_of(frame, traces)]
    for (problem, optimizer), first in cells(frame.assign(fun=firsts)).items():
        if problem in problems:
            feasible = int(np.isfinite(first).sum())
            rate, median = (feasible / len(first), float(np.median(first))) if len(first) else (np.nan, np.nan)
            rows.append((problem, optimizer, len(first), feasible, rate, median))
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trials", "feasible", "rate", "first"])
