"""How the ranking would have looked with fewer trials: mean ranks over the number of trials that count.

A ranking that still moves with the last trials needs more of them. The ranks of random subsets of the trials show how
much of a move is chance (subsampling, Politis and Romano 1994, The Annals of Statistics 22). All subsets agree once
they hold all trials; what other trials would give is the question of :func:`bench.analysis.ranking_certainty`.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis.cells import cells, complete_problems, labels
from bench.analysis.certainty import ranks_of_draws

FIRST = 3  # trials
STEPS = {30: (12, 39), 100: (8, 19)}
"""Numbers of trials, and random subsets of each, up to a number of optimizers; the extremes of 39 are 95 % limits."""
FEWEST = (4, 9)  # of more optimizers, as the cost grows with their square

COLUMNS = ("optimizer", "trials", "rank", "low", "high")


def rank_stability(frame: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return the mean rank of each optimizer with its first 3, …, all trials: optimizer, trials, rank, low and high.

    ``rank`` is that of :func:`bench.analysis.standings`, the mean over the problems on which every optimizer has a
    trial; ``low`` to ``high`` is the range of it over 39 random subsets of as many trials (19 with more than 30
    optimizers, 9 with more than 100). A cell with fewer trials enters with all it has. The first trials of pooled
    instances are the first of each instance in turn. Empty with fewer than four trials in the largest cell.
    """
    by_cell, optimizers = cells(_in_turn(frame), merge=True), labels(frame, "optimizer")
    problems = complete_problems(frame)
    most = max((len(by_cell[problem, one]) for problem in problems for one in optimizers), default=0)
    if most <= FIRST or len(optimizers) < 2:
        return pd.DataFrame(columns=list(COLUMNS))
    steps, subsets = next((number for limit, number in STEPS.items() if len(optimizers) <= limit), FEWEST)
    sizes = np.unique(np.geomspace(FIRST, most, steps).round().astype(int))
    rng = np.random.default_rng(seed)
    total = np.zeros((len(optimizers), len(sizes) * (1 + subsets)))
    for problem in problems:
        values = [by_cell[problem, optimizer] for optimizer in optimizers]
        total += ranks_of_draws(values, [_subsets(len(sample), sizes, subsets, rng) for sample in values])
    means = (total / len(problems)).reshape(len(optimizers), len(sizes), 1 + subsets)
    rows = {
        "optimizer": np.repeat(np.array(optimizers, dtype=object), len(sizes)),
        "trials": np.tile(sizes, len(optimizers)),
        "rank": means[:, :, 0].ravel(),
        "low": means.min(axis=2).ravel(),
        "high": means.max(axis=2).ravel(),
    }
    return pd.DataFrame(rows)[list(COLUMNS)]


def _in_turn(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the trials in the order of their numbers within an instance, where instances are pooled."""
    if "instance" not in frame:
        return frame
    turn = frame.groupby(["problem", "optimizer", "instance"], observed=True, dropna=False).cumcount()
    return frame.iloc[np.argsort(turn.to_numpy(), kind="stable")]


def _subsets(n: int, sizes: NDArray[np.int_], subsets: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return which of n values count, (n, sizes x (1 + subsets)): the first ones, and random subsets of each size."""
    place = np.arange(n)
    orders = np.stack([place, *(rng.permutation(n) for _ in range(subsets))], axis=1)
    counted = orders[:, np.newaxis, :] < sizes[np.newaxis, :, np.newaxis]
    return np.asarray(counted.reshape(n, -1), dtype=np.float64)
