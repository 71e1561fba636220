"""Summaries of cells and pairs: the comparison matrix and the number of first ranks."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pandas as pd

from bench.analysis.cells import merge_near_ties
from bench.analysis.direction import ALPHA
from bench.analysis.standings import mean_ranks, outstanding, standings


def comparison_matrix(
    summary: pd.DataFrame,
    pairs: pd.DataFrame,
    statistic: Literal["median", "mean"] = "median",
    *,
    by: Literal["standing", "value"] = "standing",
    standing: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Return the matrix of a statistic, one row a cell: problem, optimizer, value, best and alike.

    ``value`` is the statistic, missing where it is not known. ``best`` marks the first of a problem, each of them where
    several tie, but none where half of the optimizers or more share the first place: by "standing", the one that beats
    the most rivals (:func:`bench.analysis.standings`), unless all of its trials failed; by "value", as in thesis Table
    7.2, the one with the lowest finite value. ``alike`` (italics) marks a known value that is not best, where the test
    cannot separate its cell from a best one: by "standing", no one of the two is separably lower; by "value", as in
    the thesis, the raw p of the Kolmogorov-Smirnov test is above 0.05.

    The ``statistic`` is "median", or "mean" as in the thesis, which is missing after a single failed trial. ``pairs``
    hold at least the optimizers of ``summary``. ``standing`` is that of :func:`bench.analysis.standings`, where it is
    already there.
    """
    cells = list(zip(summary["problem"], summary["optimizer"], strict=True))
    winners: set[tuple[Any, Any]]
    if by == "value":
        values = table(summary, statistic)
        lowest, values_known = _lowest(values), values.notna().sum(axis=1)
        best = lowest.mul(outstanding(lowest.sum(axis=1), values_known), axis=0)
        winners = {(problem, optimizer) for optimizer in best for problem in best.index[best[optimizer]]}
    else:
        winners = _first(summary, standings(summary, pairs) if standing is None else standing)
    open_pairs = pairs["ks_p"] > ALPHA if by == "value" else pairs["lower"] == ""
    unclear = list(
        pairs.loc[open_pairs, ["problem", "first", "second"]].astype(object).itertuples(index=False, name=None)
    )
    near = {(problem, first) for problem, first, second in unclear if (problem, second) in winners}
    near |= {(problem, second) for problem, first, second in unclear if (problem, first) in winners}
    near -= winners
    return summary[["problem", "optimizer"]].assign(
        value=summary[statistic],
        best=[cell in winners for cell in cells],
        alike=summary[statistic].notna() & np.array([cell in near for cell in cells], dtype=bool),
    )


def _first(summary: pd.DataFrame, standing: pd.DataFrame) -> set[tuple[str, str]]:
    """Return the cells that are ranked first, stand out from the others, and have a trial that did not fail."""
    rows = summary[["problem", "optimizer", "n", "failed"]].merge(standing, on=["problem", "optimizer"])
    rows = rows[rows["n"] > 0]
    by_problem = rows.groupby("problem", sort=False, observed=True)["rank"]
    first = rows["rank"] == by_problem.transform("min")
    sharing = first.groupby(rows["problem"], sort=False, observed=True).transform("sum")
    chosen = rows[first & outstanding(sharing, by_problem.transform("size")) & (rows["failed"] < rows["n"])]
    return set(zip(chosen["problem"], chosen["optimizer"], strict=True))


def ranking(summary: pd.DataFrame, pairs: pd.DataFrame, *, standing: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return one row an optimizer: problems, first, separable, worse and mean_rank.

    The unit is the problem, on which every optimizer has a trial. ``first`` counts the problems on which the optimizer
    is ranked first by :func:`bench.analysis.standings` (a tie counts for each, but for none where half of the
    optimizers or more share the first place), ``separable`` those on which it is
    separably lower than every rival, ``worse`` those on which a rival is separably lower than it; ``mean_rank`` is the
    mean of its ranks. ``standing`` is as in :func:`comparison_matrix`.
    """
    complete = medians(summary).index
    standing = standings(summary, pairs) if standing is None else standing
    standing = standing[standing["problem"].isin(complete)]
    first = _first(summary[summary["problem"].isin(complete)], standing) if len(standing) else set()
    optimizers = list(dict.fromkeys(summary["optimizer"]))
    by_optimizer = standing.assign(worse=standing["higher"] > 0).groupby("optimizer", observed=True)
    return pd.DataFrame(
        {
            "optimizer": optimizers,
            "problems": len(complete),
            "first": [sum(optimizer == label for _, optimizer in first) for label in optimizers],
            **{
                name: by_optimizer[name].sum().reindex(optimizers, fill_value=0).to_numpy(dtype=int)
                for name in ("separable", "worse")
            },
            "mean_rank": mean_ranks(standing).reindex(optimizers).to_numpy(dtype=float),
        }
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
