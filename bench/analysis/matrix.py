"""Summaries of cells and pairs: the comparison matrix of the thesis, and tables of problems by optimizers."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pandas as pd

from bench.analysis.cells import merge_near_ties
from bench.analysis.direction import ALPHA
from bench.analysis.standings import outstanding


def comparison_matrix(
    summary: pd.DataFrame, pairs: pd.DataFrame, statistic: Literal["median", "mean"] = "median"
) -> pd.DataFrame:
    """Return the matrix of a statistic as in thesis Table 7.2: problem, optimizer, value, best and alike.

    One row a cell. ``value`` is the statistic, missing where it is not known. ``best`` marks the lowest finite value of
    a problem, each of them where several tie, but none where half of the optimizers or more share the first place.
    ``alike`` (italics) marks a known value that is not best, where the raw p of the Kolmogorov-Smirnov test against a
    best one is above 0.05.

    The ``statistic`` is "median", or "mean" as in the thesis, which is missing after a single failed trial. ``pairs``
    hold at least the optimizers of ``summary``.
    """
    cells = list(zip(summary["problem"], summary["optimizer"], strict=True))
    values = table(summary, statistic)
    lowest, known = _lowest(values), values.notna().sum(axis=1)
    best = lowest.mul(outstanding(lowest.sum(axis=1), known), axis=0)
    winners = {(problem, optimizer) for optimizer in best for problem in best.index[best[optimizer]]}
    keys = ["problem", "first", "second"]
    unclear = list(pairs.loc[pairs["ks_p"] > ALPHA, keys].astype(object).itertuples(index=False, name=None))
    near = {(problem, first) for problem, first, second in unclear if (problem, second) in winners}
    near |= {(problem, second) for problem, first, second in unclear if (problem, first) in winners}
    near -= winners
    return summary[["problem", "optimizer"]].assign(
        value=summary[statistic],
        best=[cell in winners for cell in cells],
        alike=summary[statistic].notna() & np.array([cell in near for cell in cells], dtype=bool),
    )


def table(long: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return a column of a table with one row a cell as problems by optimizers, both in the order of its rows."""
    order = {key: list(dict.fromkeys(long[key])) for key in ("problem", "optimizer")}
    wide = long.pivot(index="problem", columns="optimizer", values=column)
    return wide.reindex(index=order["problem"], columns=order["optimizer"]).rename_axis(columns=None)


def medians(summary: pd.DataFrame) -> pd.DataFrame:
    """Return the median scores, problems by optimizers, of the problems on which every optimizer has a trial.

    A median is +inf where half of the trials failed. Near-ties on a problem are ties, so that two optimizers at the
    same optimum rank alike.
    """
    return _tied(table(summary, "median").dropna())


def _tied(values: pd.DataFrame) -> pd.DataFrame:
    """Return the table with near-ties within each row made ties."""
    rows = [merge_near_ties(row) for row in values.to_numpy(dtype=float)]
    return pd.DataFrame(np.reshape(rows, values.shape), index=values.index, columns=values.columns)


def _lowest(values: pd.DataFrame) -> pd.DataFrame:
    """Return flags of the cells with the lowest value of their row, ties included; none where it is not finite."""
    tied = _tied(values)
    lowest = tied.min(axis=1)
    return tied.eq(lowest.where(np.isfinite(lowest)), axis=0)
