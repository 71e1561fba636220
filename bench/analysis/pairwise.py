"""Pairs of optimizers on one problem: the two-sample Kolmogorov-Smirnov test of the thesis, its safeguards and power.

A test shows whether two optimizers differ at all; A12 shows by how much, and which of them tends to be lower.
"""

from __future__ import annotations

import warnings
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from functools import lru_cache, partial
from math import comb
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import expit, logit
from scipy.stats import false_discovery_control, ks_2samp, mannwhitneyu

from bench.analysis.cells import cells, labels
from bench.problem import Floats

Counts = NDArray[np.float32]

ALPHA = 0.05  # thesis section 7.2
TIED = 0.10  # above this share of tied values the exact test is markedly conservative
RESAMPLES = 9_999  # of every bootstrap; with the sample itself 10,000
CUTOFFS = {"large": 0.71, "medium": 0.64, "small": 0.56}  # Vargha and Delaney 2000, Table 1
RESAMPLED = 32  # optimizers up to which A12 has a bootstrap interval: those of 496 pairs take half a second
AT_ONCE = 2_000  # pairs of samples in memory
DRAWS = 2_000  # of the power of the test
EXACT = 2**23  # sums of halves up to this are exact in float32, whatever their order
LARGEST_SHIFT = 8.0  # standard deviations: complete separation for every practical sample

METHODS = ("exact", "permutation", "identical", "untestable")
COLUMNS = (
    "problem", "first", "second", "n_first", "n_second", "distance", "p", "method", "p_holm", "significant", "p_by",
    "significant_by", "p_mw", "a12", "a12_low", "a12_high", "cliffs_delta", "separated", "lower", "testable", "tied",
)  # fmt: skip


def pairwise_tests(frame: pd.DataFrame, alpha: float = ALPHA, seed: int = 0) -> pd.DataFrame:
    """Return one row a problem and pair of optimizers.

    The test: distance (the KS statistic D), its p, and the method that gave p. That is "exact", which assumes values
    without ties; "permutation", the exact permutation distribution given the ties, where more than 10 % of the values
    are tied (``tied``); "identical" where all values are equal; "untestable" where no values of so few trials could
    be significant. The last two have p = 1 and still count among the hypotheses.

    Its level: p_holm, adjusted over the pairs of the problem (Holm 1979), and significant (p_holm <= alpha); p_by,
    adjusted over all rows under any dependence (Benjamini and Yekutieli 2001), and significant_by.

    Its companions: p_mw, the raw two-sided p of Mann and Whitney; a12, the chance that a trial of ``first`` ends
    below one of ``second``, with the 95 % interval a12_low to a12_high, missing below two trials: the percentile
    bootstrap, or from 33 optimizers on that of :func:`delong_intervals`; cliffs_delta, 2 a12 - 1; separated, whether
    a12 is 0 or 1, so that the interval is one point; lower, the optimizer that a12 favours, "" where the interval holds
    0.5: the test also rejects where two optimizers differ in spread alone, and then none is the lower one.

    Assumptions: trials are independent. Failed trials count as +inf, near-ties as ties. The resamples of a ``seed`` are
    the same for every pair of as many trials. Names and methods are categories: texts would take most of the memory.
    """
    found, optimizers, problems = cells(frame, merge=True), labels(frame, "optimizer"), labels(frame, "problem")
    one, other = np.triu_indices(len(optimizers), 1)
    # Of each column one array from the beginning: many small ones would leave gaps in the memory.
    columns: dict[str, Any] = {}
    for place, problem in enumerate(problems):
        own = compare_all([found[problem, optimizer] for optimizer in optimizers], alpha, seed)
        own["method"] = pd.Categorical(own["method"], METHODS).codes
        for name, values in own.items():
            every = columns.setdefault(name, np.empty((len(problems), len(one)), dtype=values.dtype))
            every[place] = values
    columns = {name: every.ravel() for name, every in columns.items()}
    first, second = (np.tile(which, len(problems)) for which in (one, other))
    numbers: dict[str, tuple[Any, Sequence[str]]] = {
        "problem": (np.repeat(np.arange(len(problems)), len(one)), problems), "first": (first, optimizers),
        "second": (second, optimizers), "method": (columns.get("method", []), METHODS),
    }  # fmt: skip
    columns |= {name: pd.Categorical.from_codes(codes, pd.Index(known)) for name, (codes, known) in numbers.items()}
    pairs = pd.DataFrame(columns, columns=list(COLUMNS), copy=False)
    favoured = np.where(pairs["a12_low"] > 0.5, first + 1, np.where(pairs["a12_high"] < 0.5, second + 1, 0))
    return adjusted(pairs, alpha).assign(
        cliffs_delta=2 * pairs["a12"] - 1,
        separated=pairs["a12"].isin((0.0, 1.0)),
        lower=pd.Categorical.from_codes(favoured, pd.Index(["", *optimizers])),
    ).astype(dict.fromkeys(("separated", "testable", "tied"), bool))  # fmt: skip


def adjusted(pairs: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Return the rows of :func:`pairwise_tests` with their level: what follows from p and from all other rows."""
    p = pairs["p"].astype(float)
    p_holm = p.groupby(pairs["problem"], sort=False, observed=True).transform(lambda own: holm(own.to_numpy()))
    p_by = false_discovery_control(p.to_numpy(), method="by") if len(pairs) else np.empty(0)
    return pairs.assign(p_holm=p_holm, significant=p_holm <= alpha, p_by=p_by, significant_by=p_by <= alpha)


def holm(p: Floats) -> Floats:
    """Return the p-values, (k,), adjusted for k hypotheses (Holm 1979, Scandinavian Journal of Statistics 6)."""
    order = np.argsort(p)
    steps = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    return np.minimum(steps, 1.0)[np.argsort(order)]


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


def a12(this: Floats, other: Floats) -> float:
    """Return the chance that ``this`` is lower than ``other``, ties counted half (Vargha and Delaney 2000).

    Equal to ``mannwhitneyu(other, this).statistic / (n m)``; 0.5 means no tendency, NaN that a sample is empty.
    """
    if not len(this) or not len(other):
        return float("nan")
    return float(wins(this, other).mean())


def a12_replicates(this: Floats, other: Floats, seed: int | Sequence[int] = 0) -> Floats:
    """Return the A12 of 9,999 bootstrap resamples; both samples are drawn with replacement, separately.

    Samples of the same sizes are resampled alike under one seed; independent replicates need different seeds.

    Raises:
        ValueError: when a sample is empty.
    """
    n, m = len(this), len(other)
    if not n or not m:
        raise ValueError("an empty sample cannot be resampled")
    counts, rivals = _resamples(n, m, seed if isinstance(seed, int) else tuple(seed))
    exact = np.float32 if n * m <= EXACT else np.float64
    won = wins(this, other).T.astype(exact) @ counts.astype(exact, copy=False)
    sums = np.einsum("ir,ir->r", won, rivals.astype(exact, copy=False))
    return np.asarray(sums.astype(float) / (n * m))


def percentile_interval(replicates: Floats, level: float = 0.95) -> tuple[float, float]:
    """Return the percentile bootstrap interval (Efron 1981); its ends are upper order statistics among +inf."""
    ends = [(1 - level) / 2, (1 + level) / 2]
    low, high = np.quantile(replicates, ends, method="linear" if np.isfinite(replicates).all() else "higher")
    return float(low), float(high)


def effect_size(a12: float) -> str:
    """Return Vargha and Delaney's (2000) category of an A12 in either direction, "" where it is missing."""
    if np.isnan(a12):
        return ""
    size = max(a12, 1 - a12)
    return next((word for word, least in CUTOFFS.items() if size >= least), "negligible")


def tied_share(values: Floats) -> float:
    """Return the share of values that equal another one, 0 for an empty sample."""
    counts = np.unique(values, return_counts=True)[1]
    return float(counts[counts > 1].sum() / max(len(values), 1))


def resampled(optimizers: int) -> bool:
    """Return whether the intervals of A12 between as many optimizers are those of the bootstrap."""
    return optimizers <= RESAMPLED


def compare_all(samples: Sequence[Floats], alpha: float = ALPHA, seed: int = 0) -> dict[str, Any]:
    """Return those columns of :func:`pairwise_tests` that need the k samples of one problem alone.

    Each has k (k - 1) / 2 values, one a pair, in the order of :func:`itertools.combinations`. Pairs of equal sizes are
    compared at once.
    """
    one, other = np.triu_indices(len(samples), 1)
    sizes = np.array([len(sample) for sample in samples], dtype=np.int64)
    n, m = sizes[one], sizes[other]
    columns: dict[str, Any] = {
        "n_first": n, "n_second": m, "distance": np.full(len(one), np.nan), "p": np.ones(len(one)),
        "method": np.full(len(one), "untestable", dtype=object), "p_mw": np.ones(len(one)),
        **{name: np.full(len(one), np.nan) for name in ("a12", "a12_low", "a12_high")},
        "testable": np.zeros(len(one), dtype=bool), "tied": np.zeros(len(one), dtype=bool),
    }  # fmt: skip
    interval = partial(bootstrap_intervals, seed=seed) if resampled(len(samples)) else delong_intervals
    for own, these, others in alike(samples):
        for name, values in _compare(these, others, alpha).items():
            columns[name][own] = values
        if min(these.shape[1], others.shape[1]) > 1:
            columns["a12_low"][own], columns["a12_high"][own] = interval(these, others)
    return columns


def alike(samples: Sequence[Floats]) -> Iterator[tuple[NDArray[np.intp], Floats, Floats]]:
    """Yield the pairs of k samples, many of the same sizes n and m at once.

    Yields their places in the order of :func:`itertools.combinations`, (g,), and the values, (g, n) and (g, m).
    """
    one, other = np.triu_indices(len(samples), 1)
    sizes = np.array([len(sample) for sample in samples], dtype=np.int64)
    n, m = sizes[one], sizes[other]
    for sizes_of_pair in sorted(set(zip(n.tolist(), m.tolist(), strict=True))):
        same = np.flatnonzero((n == sizes_of_pair[0]) & (m == sizes_of_pair[1]))
        for own in np.split(same, range(AT_ONCE, len(same), AT_ONCE)):
            these, others = (np.array([samples[i] for i in places[own]]) for places in (one, other))
            yield own, these, others


def _compare(these: Floats, others: Floats, alpha: float) -> dict[str, Any]:
    """Compare pairs of samples, (g, n) and (g, m); an array a column."""
    columns = ks_tests(these, others, alpha)
    if not min(these.shape[1], others.shape[1]):
        return columns
    p_mw, tested = np.ones(len(these)), columns["testable"] & (columns["method"] != "identical")
    ties = _ties(these, others).any(axis=1)
    for places in (np.flatnonzero(tested & some) for some in (ties, ~ties)):
        if len(places):
            p_mw[places] = mannwhitneyu(these[places], others[places], alternative="two-sided", axis=1).pvalue
    return columns | {"a12": wins(these, others).mean(axis=(1, 2)), "p_mw": p_mw}


def ks_tests(these: Floats, others: Floats, alpha: float = ALPHA) -> dict[str, Any]:
    """Test g pairs of samples, (g, n) and (g, m); distance, p, method, testable and tied of :func:`pairwise_tests`."""
    n, m = these.shape[1], others.shape[1]
    equal = _ties(these, others)
    tied = (equal[:, 1:] | equal[:, :-1]).mean(axis=1) > TIED if n + m else np.zeros(len(these), dtype=bool)
    distance, p = np.full(len(these), np.nan), np.ones(len(these))
    method, testable = np.full(len(these), "untestable", dtype=object), np.zeros(len(these), dtype=bool)
    columns = {"distance": distance, "p": p, "method": method, "testable": testable, "tied": tied}
    if not min(n, m):
        return columns
    distance[:] = ks_distance(these, others)
    # The smallest exact p that n and m values allow: complete separation, 2 of C(n + m, n) arrangements.
    if 2 / comb(n + m, n) > alpha:
        return columns
    testable[:] = True
    identical, steps = equal[:, 1:-1].all(axis=1), np.rint(n * m * distance).astype(np.int64)
    method[:] = np.where(identical, "identical", np.where(tied, "permutation", "exact"))
    exact, permuted = np.flatnonzero(~identical & ~tied), np.flatnonzero(~identical & tied)
    for place in exact[np.unique(steps[exact], return_index=True)[1]]:  # without ties p depends on D alone
        known = n == m and steps[place] > 0
        own = _p_of(int(steps[place]) // n, n) if known else _exact_p(these[place], others[place])
        p[exact[steps[exact] == steps[place]]] = own
    if len(permuted):  # and with them on where they lie: many pairs share the places
        keys = np.column_stack((steps, equal))[permuted]
        _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        p[permuted] = permutation_p(these[permuted[first]], others[permuted[first]])[which.ravel()]
    return columns


def _ties(these: Floats, others: Floats) -> NDArray[np.bool_]:
    """Return (g, n + m + 1), whether neighbours among the sorted values of a pair are equal; no end has a neighbour."""
    pooled = np.sort(np.concatenate((these, others), axis=1), axis=1)
    return np.pad(pooled[:, 1:] == pooled[:, :-1], ((0, 0), (1, 1)))


def bootstrap_intervals(these: Floats, others: Floats, seed: int = 0) -> tuple[Floats, Floats]:
    """Return the ends of the 95 % percentile bootstrap intervals of A12 of pairs of samples, (g, n) and (g, m)."""
    ends = [percentile_interval(a12_replicates(this, other, seed)) for this, other in zip(these, others, strict=True)]
    low, high = np.array(ends).reshape(-1, 2).T
    return low, high


def delong_intervals(these: Floats, others: Floats) -> tuple[Floats, Floats]:
    """Return the ends of the 95 % intervals of A12 of pairs of samples, (g, n) and (g, m), n and m at least 2."""
    return logit_intervals(*delong(these, others))


def delong(these: Floats, others: Floats) -> tuple[Floats, Floats]:
    """Return A12 and its variance, (g,) each, of pairs of samples, (g, n) and (g, m); missing where n or m is 1.

    The variance is that of DeLong, DeLong and Clarke-Pearson (1988, Biometrics 44): of the placements of each sample
    in the other one.
    """
    won = wins(these, others)
    n, m = won.shape[1:]
    chance, variance = won.mean(axis=(1, 2)), np.full(len(won), np.nan)
    if min(n, m) > 1:
        variance = won.mean(axis=2).var(axis=1, ddof=1) / n + won.mean(axis=1).var(axis=1, ddof=1) / m
    return chance, variance


def logit_intervals(chance: Floats, variance: Floats) -> tuple[Floats, Floats]:
    """Return the ends of the 95 % intervals of chances, (g,), that are symmetric on the logit scale.

    Pepe (2003, The Statistical Evaluation of Medical Tests, section 5.2). A chance of 0 or 1 has an interval of one
    point, as in the bootstrap.
    """
    inside = (chance > 0) & (chance < 1)
    width = np.zeros(len(chance))
    width[inside] = 1.959963984540054 * np.sqrt(variance[inside]) / (chance * (1 - chance))[inside]
    with np.errstate(divide="ignore"):
        centre = logit(chance)
    return expit(centre - width), expit(centre + width)


def _exact_p(this: Floats, other: Floats) -> float:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "ks_2samp: Exact calculation", RuntimeWarning)  # warns needlessly at D = 1/n
        return float(ks_2samp(this, other, method="exact").pvalue)


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
    return _share_as_far(changes, np.rint(n * m * ks_distance(these, others)), n)


def _share_as_far(changes: NDArray[np.bool_], reached: Floats, n: int) -> Floats:
    """Return the share of the arrangements of n values and others whose distance is as large, (g,).

    Args:
        changes: (g, n + m), whether the value changes after each of the sorted values.
        reached: (g,) distances times n m.
        n: the values of the first sample.
    """
    m = changes.shape[1] - n
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


def wins(this: Floats, other: Floats) -> Floats:
    """Return (…, n, m): 1 where a value of ``this``, (…, n), is the lower one, 1/2 where they tie and 0 elsewhere."""
    one, rival = this[..., :, np.newaxis], other[..., np.newaxis, :]
    return np.asarray((one < rival) + 0.5 * (one == rival), dtype=np.float64)


@lru_cache(maxsize=4)
def _resamples(n: int, m: int, seed: int | tuple[int, ...]) -> tuple[Counts, Counts]:
    """Return how often each of n and each of m values is drawn in each resample, (n, 9999) and (m, 9999)."""
    rng = np.random.default_rng(seed)
    return _times_drawn(n, rng), _times_drawn(m, rng)


def _times_drawn(n: int, rng: np.random.Generator) -> Counts:
    drawn = rng.integers(n, size=(RESAMPLES, n)) + n * np.arange(RESAMPLES)[:, np.newaxis]
    counts = np.bincount(drawn.ravel(), minlength=drawn.size).reshape(drawn.shape)
    return np.ascontiguousarray(counts.T, dtype=np.float32)


@lru_cache(maxsize=4096)
def critical_distance(n: int, alpha: float) -> int | None:
    """Return the smallest k for which D = k/n between two samples of n values has an exact p <= alpha.

    None when even complete separation (k = n) does not reach it.
    """
    smallest = 1 + bisect_left(range(1, n + 1), -alpha, key=lambda k: -_p_of(k, n))  # p decreases with k
    return smallest if smallest <= n else None


def tied_critical_distance(changes: NDArray[np.bool_], level: float) -> int | None:
    """Return the smallest k for which D = k/n between two samples of n tied values has a p <= level.

    ``changes``, (2n,), says whether the value changes after each of the sorted values; p is that of
    :func:`permutation_p`. None where even samples without ties have no such k.
    """
    n = len(changes) // 2
    most = critical_distance(n, level)  # ties only make large distances rarer
    if most is None:
        return None

    def enough(k: int) -> bool:
        return bool(_share_as_far(changes[np.newaxis], np.array([float(k * n)]), n)[0] <= level)

    return 1 + bisect_left(range(1, most), True, key=enough)


@lru_cache
def detectable_shift(n: int, alpha: float, power: float = 0.8) -> float | None:
    """Return the shift, in standard deviations, that the test detects with the given power; None where it detects none.

    Assumes two normal samples of n values that differ by a shift only. Found by bisection over 2,000 seeded draws,
    so good to about 0.02.
    """
    needed = critical_distance(n, alpha)
    if needed is None:
        return None
    rng = np.random.default_rng(20_250_101)
    this, other = rng.standard_normal((2, DRAWS, n))
    low, high = 0.0, LARGEST_SHIFT
    for _ in range(12):
        shift = (low + high) / 2
        seen = np.mean((n * ks_distance(this, other + shift)).round() >= needed)
        low, high = (low, shift) if seen >= power else (shift, high)
    return high


def power_table(n: int, pairs: int, alpha: float = ALPHA) -> pd.DataFrame:
    """Return the differences that n trials a cell can show: level, alpha, distance (in units of 1/n) and shift.

    The rows are ``alpha`` itself and, where several pairs are tested, the first step of Holm's adjustment, alpha
    over the number of pairs. ``distance`` is the :func:`critical_distance` and ``shift`` the
    :func:`detectable_shift`; both are missing where nothing can be significant.
    """
    levels = {"alpha": alpha} | ({"first Holm step": alpha / pairs} if pairs > 1 else {})
    rows = [(name, level, critical_distance(n, level), detectable_shift(n, level)) for name, level in levels.items()]
    table = pd.DataFrame(rows, columns=["level", "alpha", "distance", "shift"])
    return table.astype({"distance": float, "shift": float})


@lru_cache(maxsize=4096)
def _p_of(k: int, n: int) -> float:
    """Return the exact p of D = k/n: that of n values against the same values moved up by k ranks."""
    values = np.arange(n, dtype=float)
    return _exact_p(values, values + k - 0.5)
