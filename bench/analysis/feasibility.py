"""How often, and how soon, the trials on constrained problems found a feasible point."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pandas as pd

from bench.analysis.cells import Traces, labels, scores


def feasibility(frame: pd.DataFrame, traces: Traces, problems: Collection[str]) -> pd.DataFrame:
    """Return how many trials of each cell found a feasible point, and after how many evaluations.

    A trial on a constrained problem records feasible points only (:mod:`bench.scoring.constraints`): it found one where
    its value is finite, first at the first evaluation of its trace. A failed trial counts as one without.

    Args:
        frame: the tidy frame.
        traces: of its trials.
        problems: the labels of the constrained problems.

    Returns:
        One row a cell with columns problem, optimizer, trials, feasible (trials), rate (their share, NaN without a
        trial), first (the median evaluation, from 1, of the first feasible point; +inf where at least half of the
        trials found none, NaN without a trial).
    """
    rows = []
    feasible = scores(frame).lt(np.inf)
    for problem in (label for label in labels(frame, "problem") if label in problems):
        for optimizer in labels(frame, "optimizer"):
            mine = feasible[(frame["problem"] == problem) & (frame["optimizer"] == optimizer)]
            numbers = frame.loc[mine.index[mine], "trial"]
            first = [int(traces[problem, optimizer, trial].evaluations[0]) for trial in numbers]
            every = sorted(first) + [np.inf] * (len(mine) - len(first))
            rows.append(
                {
                    "problem": problem,
                    "optimizer": optimizer,
                    "trials": len(mine),
                    "feasible": len(first),
                    "rate": len(first) / len(mine) if len(mine) else np.nan,
                    "first": float(np.median(every)) if every else np.nan,
                }
            )
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trials", "feasible", "rate", "first"])
