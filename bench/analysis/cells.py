"""The cells of a study, one a problem and optimizer: their scores, their completeness and their summary.

A failed or non-finite trial scores +inf: it is the worst that can happen, and leaving it out would reward failing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from bench.problem import Floats
from bench.study import Study


def in_study_order(frame: pd.DataFrame, study: Study) -> pd.DataFrame:
    """Return the tidy frame with ``problem`` and ``optimizer`` as categories of the study, in its order.

    Every function of this package then sees cells without any trial too; a plain frame knows only those it holds.
    """
    kinds = {"problem": study.problems, "optimizer": study.optimizers}
    columns = {
        column: pd.Categorical(frame[column], categories=[entry.label for entry in entries])
        for column, entries in kinds.items()
    }
    return frame.assign(**columns)


def labels(frame: pd.DataFrame, column: str) -> list[str]:
    """Return the labels of ``problem`` or ``optimizer``: the study's where known, else in order of appearance."""
    values = frame[column]
    if isinstance(values.dtype, pd.CategoricalDtype):
        return list(values.cat.categories)
    return list(values.unique())


def scores(frame: pd.DataFrame) -> pd.Series[float]:
    """Return each trial's objective value as float64, +inf where the trial failed or its value is not finite."""
    values = pd.to_numeric(frame["fun"], errors="coerce").astype(float)
    return values.where((frame["status"] == "ok") & np.isfinite(values), np.inf)


def cells(frame: pd.DataFrame) -> dict[tuple[str, str], Floats]:
    """Return the scores of each (problem, optimizer), (n,) in order of trials, empty where there is none."""
    keys = [frame["problem"].astype(object), frame["optimizer"].astype(object)]
    found: dict[Any, Floats] = {
        key: np.asarray(values, dtype=np.float64) for key, values in scores(frame).groupby(keys)
    }
    return {
        (problem, optimizer): found.get((problem, optimizer), np.empty(0))
        for problem in labels(frame, "problem")
        for optimizer in labels(frame, "optimizer")
    }


def coverage(frame: pd.DataFrame, planned: int) -> pd.DataFrame:
    """Return problem, optimizer, stored, failed and missing (of ``planned``) trials of each cell."""
    rows = [
        {
            "problem": problem,
            "optimizer": optimizer,
            "stored": len(values),
            "failed": int(np.isinf(values).sum()),
            "missing": max(planned - len(values), 0),
        }
        for (problem, optimizer), values in cells(frame).items()
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "stored", "failed", "missing"])


def summarise(frame: pd.DataFrame) -> pd.DataFrame:
    """Return one row a cell: n, failed, mean, sd (n - 1), median, q1, q3, best and worst of the scores.

    Mean and sd are missing as soon as one trial failed, since no finite number stands for a failure; median and
    quartiles then are the upper order statistics, as nothing lies between a number and infinity.
    """
    rows = [
        {"problem": problem, "optimizer": optimizer, **_describe(values)}
        for (problem, optimizer), values in cells(frame).items()
    ]
    statistics = ["n", "failed", "mean", "sd", "median", "q1", "q3", "best", "worst"]
    return pd.DataFrame(rows, columns=["problem", "optimizer", *statistics])


def _describe(values: Floats) -> dict[str, Any]:
    n, failed = len(values), int(np.isinf(values).sum())
    if n == 0:
        return {"n": 0, "failed": 0}
    q1, median, q3 = np.quantile(values, [0.25, 0.5, 0.75], method="higher" if failed else "linear")
    return {
        "n": n,
        "failed": failed,
        "mean": values.mean() if not failed else np.nan,
        "sd": values.std(ddof=1) if not failed and n > 1 else np.nan,
        "median": median,
        "q1": q1,
        "q3": q3,
        "best": values.min(),
        "worst": values.max(),
    }
