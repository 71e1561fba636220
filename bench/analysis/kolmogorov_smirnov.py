"""The two-sample Kolmogorov-Smirnov test of the thesis: whether two optimizers' results have one distribution.

It also rejects where they differ in spread alone; which one is lower is the question of
:mod:`bench.analysis.direction`.
"""

from __future__ import annotations

import warnings
from functools import lru_cache

import numpy as np
from scipy.stats import ks_2samp

from bench.contract.typing import Flags, Floats

TIED = 0.10  # above this share of tied values the exact test is markedly conservative


def ks_distance(this: Floats, other: Floats) -> Floats:
    """Return D, the largest distance between two samples' distribution functions, along the last axis.

    Equal to the statistic of ``scipy.stats.ks_2samp``, but for many pairs of samples, (…, n) and (…, m), at once.
    """
    n, m = this.shape[-1], other.shape[-1]
    values = np.concatenate((this, other), axis=-1)
    order = values.argsort(axis=-1)
    values = np.take_along_axis(values, order, axis=-1)
    steps = np.where(order < n, m, -n).cumsum(axis=-1)  # n m times the distance, in whole numbers
    stepped = values[..., :-1] != values[..., 1:]  # tied values are one step
    return np.asarray(np.abs(steps[..., :-1] * stepped).max(axis=-1) / (n * m))


def ks_tests(these: Floats, others: Floats) -> dict[str, Floats | Flags]:
    """Test g pairs of samples, (g, n) and (g, m), n and m at least 1: ks_distance, ks_p and ks_tied, (g,) each.

    p is exact; where more than 10% of the values are tied (``ks_tied``), by the permutation distribution given the
    ties.
    """
    n, m = these.shape[1], others.shape[1]
    pooled = np.sort(np.concatenate((these, others), axis=1), axis=1)
    equal = np.pad(pooled[:, 1:] == pooled[:, :-1], ((0, 0), (1, 1)))  # no end has a neighbour
    tied = (equal[:, 1:] | equal[:, :-1]).mean(axis=1) > TIED
    distance, p = ks_distance(these, others), np.ones(len(these))
    steps = np.rint(n * m * distance).astype(np.int64)
    exact, permuted = np.flatnonzero(~tied), np.flatnonzero(tied & (steps > 0))
    for place in exact[np.unique(steps[exact], return_index=True)[1]]:  # without ties p depends on D alone
        tabled = n == m and steps[place] > 0
        chance = _p_of(int(steps[place]) // n, n) if tabled else _exact_p(these[place], others[place])
        p[exact[steps[exact] == steps[place]]] = chance
    if len(permuted):  # and with them on where they lie: many pairs share the places
        keys = np.column_stack((steps, equal))[permuted]
        _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        p[permuted] = permutation_p(these[permuted[first]], others[permuted[first]])[which.ravel()]
    return {"ks_distance": distance, "ks_p": p, "ks_tied": tied}


def permutation_p(these: Floats, others: Floats) -> Floats:
    """Return the share of all arrangements of the pooled values whose D is as large, ties and all, of g pairs, (g,).

    What ``scipy.stats.permutation_test`` estimates from random shuffles, computed exactly: each arrangement is a path
    that takes a step for every pooled value in order, and D may be reached only where the value changes (Schröer and
    Trenkler 1995, Computational Statistics & Data Analysis 20). Without ties it is the p of ``ks_2samp``.

    Args:
        these: (g, n) samples.
        others: (g, m), the other sample of each pair.
    """
    pooled = np.sort(np.concatenate((these, others), axis=1), axis=1)
    changes = np.pad(pooled[:, 1:] != pooled[:, :-1], ((0, 0), (0, 1)), constant_values=True)
    n, m = these.shape[1], others.shape[1]
    reached = np.rint(n * m * ks_distance(these, others))
    taken = np.arange(n + 1)  # values of the first sample among those passed
    inside, outside = np.zeros((len(changes), n + 1)), np.zeros(len(changes))
    inside[:, 0] = 1.0
    for passed in range(n + m):
        share = np.clip((n - taken) / (n + m - passed), 0.0, 1.0)
        moved = inside * share
        inside -= moved
        inside[:, 1:] += moved[:, :-1]
        far = (np.abs(taken * m - (passed + 1 - taken) * n) >= reached[:, np.newaxis]) & changes[:, [passed]]
        outside += np.where(far, inside, 0.0).sum(axis=1)
        inside[far] = 0.0
    return np.minimum(outside, 1.0)


def _exact_p(this: Floats, other: Floats) -> float:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "ks_2samp: Exact calculation", RuntimeWarning)  # warns needlessly at D = 1/n
        return float(ks_2samp(this, other, method="exact").pvalue)


@lru_cache(maxsize=4096)
def _p_of(k: int, n: int) -> float:
    """Return the exact p of D = k/n: that of n values against the same values moved up by k ranks."""
    values = np.arange(n, dtype=float)
    return _exact_p(values, values + k - 0.5)
