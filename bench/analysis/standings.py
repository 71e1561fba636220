"""The standing of each optimizer on a problem: its chance to end lower than a rival.

The chance is the mean over the rivals of A12 (Vargha and Delaney 2000), by which :mod:`bench.analysis.comparison`
orders everything. A median would be no such number: that of a cell whose trials end in two basins says which basin
holds one more trial than the other, and so may rank an optimizer first whose trials mostly end higher.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from bench.contract.typing import Floats
from bench.helpers.compiled import compiled


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


def outstanding(sharing: Any, optimizers: Any) -> Any:
    """Return whether the first ones of a problem stand out: one of several, or fewer than half of the optimizers.

    Args:
        sharing: the number of optimizers that are first; an array, or a series with one number a problem or cell.
        optimizers: the number of optimizers with trials, likewise or one number.
    """
    return (optimizers > 1) & ((sharing == 1) | (2 * sharing < optimizers))
