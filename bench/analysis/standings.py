"""The standing of each optimizer on a problem: its chance to end lower than a rival, and whom it is separable from.

The chance is the mean over the rivals of A12 (Vargha and Delaney 2000), by which :mod:`bench.analysis.comparison`
orders everything. An optimizer is *separably lower* than another one where the adjusted test rejects A12 = 0.5 as well
(:func:`bench.analysis.pairwise_tests`). A median would be no such number: that of a cell whose trials end in two basins
says which basin holds one more trial than the other, and so may rank an optimizer first whose trials mostly end higher.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import rankdata

from bench.analysis.cells import labels
from bench.helpers.compiled import compiled
from bench.typing import Floats

COLUMNS = ("problem", "optimizer", "rank", "chance", "lower", "higher", "separable")


def standings(summary: pd.DataFrame, pairs: pd.DataFrame) -> pd.DataFrame:
    """Return one row a cell: problem, optimizer, rank, chance, lower, higher and separable.

    ``chance`` is the mean A12 against the rivals, and ``rank`` 1 where it is highest; ties share their mean rank.
    ``lower`` counts the rivals that it is separably lower than, ``higher`` those that are separably lower than
    it, and ``separable`` says whether it is separably lower than every rival.

    All are missing, or 0, for a cell without trials, which is no rival either. ``pairs`` hold at least the optimizers
    of ``summary``.
    """
    tables = []
    own_pairs = dict(list(pairs.groupby("problem", sort=False, observed=True)))
    for problem, of_problem in summary.groupby("problem", sort=False, observed=True):
        present = of_problem.loc[of_problem["n"] > 0, "optimizer"].astype(object)
        chances, separable = matrices(own_pairs.get(problem, pairs.head(0)), list(present))
        rivals = len(present) - 1
        chance = mean_chance(chances) if rivals > 0 else np.full(len(present), np.nan)
        columns = {
            "optimizer": present.to_numpy(), "rank": ranks(chance), "chance": chance,
            "lower": separable.sum(axis=1), "higher": separable.sum(axis=0),
            "separable": separable.sum(axis=1) == max(rivals, 1),
        }  # fmt: skip
        rows = of_problem[["problem", "optimizer"]].merge(pd.DataFrame(columns), on="optimizer", how="left")
        tables.append(rows)
    if not tables:
        return pd.DataFrame(columns=list(COLUMNS))
    table = pd.concat(tables, ignore_index=True)
    counts = {name: table[name].astype(float).fillna(0).astype(int) for name in ("lower", "higher")}
    return table.assign(**counts, separable=table["separable"].eq(True))[list(COLUMNS)]


def mean_chance(chances: Floats) -> Floats:
    """Return the mean A12 of each of k optimizers against the others, (k,), from (k, k) with 0.5 on the diagonal."""
    return np.asarray((chances.sum(axis=1) - 0.5) / max(len(chances) - 1, 1))


def a12_matrix(samples: Sequence[Floats]) -> Floats:
    """Return A12 of each of k samples against each other one, (k, k), 0.5 against itself."""
    owner = np.repeat(np.arange(len(samples)), [len(sample) for sample in samples])
    pooled = np.concatenate(samples)
    order = pooled.argsort(kind="stable")
    ends = pooled[order].searchsorted(pooled[order], "right")
    lost = np.zeros((len(samples), len(samples)))
    compiled(_pass, "void(int64[::1], int64[::1], float64[:, ::1])")(
        owner[order].astype(np.int64), ends.astype(np.int64), lost
    )
    sizes = np.array([len(sample) for sample in samples], dtype=np.float64)
    chances = lost.T / 2 / np.outer(sizes, sizes)  # sums of whole numbers: exact
    np.fill_diagonal(chances, 0.5)
    return np.asarray(chances)


def _pass(owner: NDArray[np.int64], ends: NDArray[np.int64], pairs: Floats) -> None:
    """Add to ``pairs``, (k, k), twice the pairs of values of which the second one's is lower, a tie counted half.

    Values come in order, and equal ones have the same end. Before a group of equal values, the counts of each owner are
    those that are lower, and after it those that are not higher.
    """
    below = np.zeros(len(pairs))
    start = 0
    while start < len(owner):
        for after in range(2):
            for place in range(start, ends[start]):
                for rival in range(len(below)):
                    pairs[owner[place], rival] += below[rival]
            for place in range(start, ends[start] * (1 - after)):
                below[owner[place]] += 1
        start = ends[start]


def ranks(chance: Floats) -> Floats:
    """Return the rank of each of k optimizers, (k,), by their chance to end lower: 1 is best, a missing one last."""
    return np.asarray(rankdata(-np.round(np.nan_to_num(chance), 9)))  # sums of rounded shares differ in last digits


def disagreements(summary: pd.DataFrame, standing: pd.DataFrame) -> pd.DataFrame:
    """Return the problems on which median, mean and standing name different best optimizers.

    Columns: problem, standing, median and mean, each a list of the optimizers that are best by it. The mean counts only
    where every optimizer has one: a failed trial leaves none. Optimizers that tie are all best.
    """
    table = summary.merge(standing[["problem", "optimizer", "rank"]], on=["problem", "optimizer"])
    rows = []
    for problem, of_problem in table[table["n"] > 0].groupby("problem", sort=False, observed=True):
        best = {"standing": _lowest(of_problem, "rank"), "median": _lowest(of_problem, "median")}
        best["mean"] = _lowest(of_problem, "mean") if of_problem["mean"].notna().all() else []
        named = [set(labels_of) for labels_of in best.values() if labels_of]
        if len(named) > 1 and not set.intersection(*named):
            rows.append({"problem": problem, **best})
    return pd.DataFrame(rows, columns=["problem", "standing", "median", "mean"])


def _lowest(of_problem: pd.DataFrame, column: str) -> list[str]:
    values = of_problem[column].to_numpy(dtype=float)
    least = values.min()
    if not np.isfinite(least):
        return []
    return list(of_problem.loc[np.isclose(values, least, rtol=1e-10, atol=0), "optimizer"])


def matrices(pairs: pd.DataFrame, optimizers: Sequence[str]) -> tuple[Floats, NDArray[np.bool_]]:
    """Return (k, k) A12 of the first against the second, and whether the first is separably lower."""
    place = {optimizer: i for i, optimizer in enumerate(optimizers)}
    rows = pairs[pairs["first"].isin(place) & pairs["second"].isin(place)]
    first, second = (rows[name].astype(object).map(place).to_numpy(dtype=int) for name in ("first", "second"))
    chances = np.full((len(place), len(place)), 0.5)
    a12 = rows["a12"].to_numpy(dtype=float)
    chances[first, second], chances[second, first] = a12, 1 - a12
    separable = np.zeros(chances.shape, dtype=bool)
    lower = rows["lower"].to_numpy(dtype=object)
    for one, rival, name in ((first, second, "first"), (second, first, "second")):
        wins = lower == rows[name].to_numpy(dtype=object)
        separable[one[wins], rival[wins]] = True
    return chances, separable


def outstanding(sharing: Any, optimizers: Any) -> Any:
    """Return whether the first ones of a problem stand out: one of several, or fewer than half of the optimizers.

    Args:
        sharing: the number of optimizers that are first; an array, or a series with one number a problem or cell.
        optimizers: the number of optimizers with trials, likewise or one number.
    """
    return (optimizers > 1) & ((sharing == 1) | (2 * sharing < optimizers))


def mean_ranks(standing: pd.DataFrame) -> pd.Series[float]:
    """Return the mean rank of each optimizer over the problems on which every optimizer has a rank."""
    return complete_ranks(standing).mean().rename_axis(None)


def complete_ranks(standing: pd.DataFrame) -> pd.DataFrame:
    """Return the ranks, problems by optimizers, on the problems on which every optimizer has one."""
    order = labels(standing, "optimizer")
    return standing.pivot(index="problem", columns="optimizer", values="rank").reindex(columns=order).dropna()
