"""Which of two samples tends to be lower: A12, a test of A12 = 0.5 that allows unequal spread, and intervals of A12.

A12 is the chance that a value of the first sample is lower than one of the second, ties counted half (Vargha and
Delaney 2000, Journal of Educational and Behavioral Statistics 25). Two optimizers may have A12 = 0.5 and yet differ
in spread, or in the number of their basins; a test of equal distributions rejects there and shows no direction. The
test here has the null hypothesis A12 = 0.5 itself, the nonparametric Behrens-Fisher problem.

The variance of the estimate, from the placements of each sample in the other one (DeLong, DeLong and Clarke-Pearson
1988, Biometrics 44; Brunner and Munzel 2000, Biometrical Journal 42), shrinks as the estimate leaves 0.5, so that the
test of Brunner and Munzel rejects far too often at the small levels that many comparisons need. Its ratio to
A12 (1 - A12), the form of its largest possible value (Birnbaum and Klose 1957, The Annals of Mathematical Statistics
28), does not. Test and interval take this ratio for known, and the variance under a hypothesis A12 = a as ratio times
a (1 - a). That is the approach of Schüürhuis, Konietschke and Brunner (2025, Biometrical Journal 67,
doi:10.1002/bimj.70096), whose test controls its level where that of Brunner and Munzel does not. So the interval never
leaves 0 to 1, and holds those a that the test does not reject. Quantiles are those of the normal distribution, which
kept the level in simulations where those of Student's t made the test needlessly weak (validation/intervals.py).

Two bounds keep both honest where samples are small or separated. The ratio is at least three quarters of that of two
equal distributions, which is four times the variance of A12 if the values at hand, with their ties, are dealt to the
two samples at random (Lehmann 1975, Nonparametrics, section 1.4). At least :data:`UNTIED` values count as different
from all others, since samples of one value do not show that there is no other. And where A12 = a, all of min(n, m)
disjoint pairs of one value each are won with a chance of at most a^min(n, m), whatever the distributions are: complete
separation has no p below 2^(1 - min(n, m)), and its interval reaches as far as this chance does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import norm, t

from bench.contract.typing import Floats
from bench.helpers.compiled import compiled

ALPHA = 0.05  # thesis section 7.2
TWO_SIDED = 1.959963984540054  # the normal quantile of 0.975
LEAST_SHARE = 0.75  # of the ratio of two equal distributions
UNTIED = 6  # values that always count as different from all others
COUNTED = 0.75
"""The part of the largest variance, that of a share of runs, from which on A12 counts as one; equal samples: 0.69."""


class Effects(NamedTuple):
    """A12 of g pairs of samples of n and of m values, and how sure it is.

    Attributes:
        a12: (g,) the estimates.
        ratio: (g,) the variance of each estimate over A12 (1 - A12); NaN where a sample has a single value.
        smaller: the smaller of n and m, one number or (g,).
    """

    a12: Floats
    ratio: Floats
    smaller: float | Floats

    @property
    def inside(self) -> Floats:
        """The estimates with one more pair of trials that is won, and one that is lost: never 0 or 1.

        After Agresti and Coull (1998, The American Statistician 52).
        """
        return np.asarray((self.a12 * self.smaller + 1) / (self.smaller + 2))

    @property
    def variance(self) -> Floats:
        """The variance of each estimate, (g,), above 0 also where samples are separated."""
        return np.asarray(self.ratio * self.inside * (1 - self.inside))


def wins(this: Floats, other: Floats) -> Floats:
    """Return (…, n, m): 1 where a value of ``this``, (…, n), is the lower one, 1/2 where they tie and 0 elsewhere."""
    one, rival = this[..., :, np.newaxis], other[..., np.newaxis, :]
    return np.asarray((one < rival) + 0.5 * (one == rival), dtype=np.float64)


def a12(this: Floats, other: Floats) -> float:
    """Return the chance that ``this`` is lower than ``other``, ties counted half; NaN where a sample is empty."""
    if not len(this) or not len(other):
        return float("nan")
    return float(wins(this, other).mean())


def effects(these: Floats, others: Floats) -> Effects:
    """Return A12 of g pairs of samples, (g, n) and (g, m); the ratio is missing where a sample has a single value."""
    (g, n), m = these.shape, others.shape[1]
    this, other = (np.ascontiguousarray(np.sort(each, axis=1), np.float64) for each in (these, others))
    lost, won = np.empty((2, g, 3), dtype=np.int64)
    placements = compiled(_placements, "void(float64[:, ::1], float64[:, ::1], int64[:, ::1])")
    placements(this, other, lost)
    placements(other, this, won)
    return _estimated(n, m, lost, won)


def _estimated(n: int, m: int, lost: NDArray[np.int64], won: NDArray[np.int64]) -> Effects:
    """Return the estimates for g pairs of n and m values, from the sums of their :func:`_placements`, (g, 3) each."""
    total = won[:, 0].astype(np.float64)
    chance = total / (2 * n * m)
    if min(n, m) < 2:
        return Effects(chance, np.full(len(chance), np.nan), min(n, m))
    # The squares of what the values of the first sample beat: all there is less what they lose to.
    one, two = (lost[:, 1] + 4 * m * (n * m - lost[:, 0])).astype(np.float64), won[:, 1].astype(np.float64)
    variance = (one - total**2 / n) / (4 * m**2 * n * (n - 1)) + (two - total**2 / m) / (4 * n**2 * m * (m - 1))
    largest = chance * (1 - chance)
    both, most = n + m, max(n + m - UNTIED, 0)
    tied = np.minimum((lost[:, 2] + won[:, 2]).astype(np.float64) - both, float(most**3 - most))  # sum of t^3 - t
    least = LEAST_SHARE * (both + 1 - tied / (both * (both - 1))) / (3 * n * m)
    ratio = np.divide(variance, largest, out=np.zeros_like(chance), where=largest > 0)
    return Effects(chance, np.maximum(ratio, least), min(n, m))


def _placements(these: Floats, others: Floats, sums: NDArray[np.int64]) -> None:
    """Write sums over the values of the first of g pairs of sorted samples into ``sums``, (g, 3).

    These are the sum and the sum of squares of their placements, and that of the squares of their ties. The placement
    of a value is twice the number of values of the other sample that it loses to, a tie counted half, and its ties are
    the values of both samples that equal it, itself included: whole numbers, so the sums are exact.
    """
    n, m = these.shape[1], others.shape[1]
    for pair in range(len(these)):
        total = squares = ties = below = upto = start = 0
        while start < n:
            value, end = these[pair, start], start + 1
            while end < n and these[pair, end] == value:
                end += 1
            while below < m and others[pair, below] < value:
                below += 1
            upto = max(upto, below)
            while upto < m and others[pair, upto] == value:
                upto += 1
            total += (end - start) * (below + upto)
            squares += (end - start) * (below + upto) ** 2
            ties += (end - start) * (end - start + upto - below) ** 2
            start = end
        sums[pair, 0], sums[pair, 1], sums[pair, 2] = total, squares, ties


def stacked(estimates: Sequence[Effects]) -> Effects:
    """Return several estimates of one shape, (…) each, as one of (number, …)."""
    chances, ratios, sizes = zip(*estimates, strict=True)
    smaller = [np.broadcast_to(size, chance.shape) for size, chance in zip(sizes, chances, strict=True)]
    return Effects(np.array(chances), np.array(ratios), np.array(smaller, dtype=np.float64))


def stratified(strata: Sequence[Effects]) -> Effects:
    """Return the mean of independent estimates of one problem, such as those on its instances, of one shape each.

    Its variance is the one that A12 = mean on each of them would have, which is the largest there is.
    """
    if len(strata) == 1:
        return strata[0]
    number, every = len(strata), stacked(strata)
    smaller = number * np.min(every.smaller, axis=0)
    return Effects(every.a12.mean(axis=0), every.ratio.mean(axis=0) / number, smaller)


def p_values(estimates: Effects) -> Floats:
    """Return the two-sided p-values of A12 = 0.5, (g,), never below :func:`least_p`."""
    size = np.abs(standardised(estimates.a12[np.newaxis], estimates.ratio[np.newaxis]))
    return np.asarray(np.fmax(2 * norm.sf(size), least_p(estimates.smaller)), dtype=np.float64)  # 1 of single values


def standardised(chances: Floats, ratios: Floats, axis: int = 0) -> Floats:
    """Return how far the mean of independent A12 along an axis is from 0.5, in its standard errors where all are 0.5.

    ``ratios`` are those of :class:`Effects`.
    """
    number = max(chances.shape[axis], 1)
    with np.errstate(invalid="ignore"):  # without any, it is missing
        return np.asarray((chances - 0.5).sum(axis=axis) / number / (0.5 * np.sqrt(ratios.sum(axis=axis)) / number))


def least_p(smaller: ArrayLike) -> Floats:
    """Return the p of complete separation, the smallest there is, by the number of values of the smaller sample."""
    return np.minimum(2.0 ** (1 - np.asarray(smaller, dtype=np.float64)), 1.0)


def intervals(estimates: Effects, level: float = 0.95) -> tuple[Floats, Floats]:
    """Return both ends of the intervals of A12, (g,) each: the form of Wilson's (1927) interval of a proportion."""
    low, high = wilson_form(estimates.a12, estimates.ratio, float(norm.ppf((1 + level) / 2)))
    apart = ((1 - level) / 2) ** (1 / estimates.smaller)  # the lower end that complete separation allows
    return np.minimum(low, apart), np.maximum(high, 1 - apart)


def wilson_form(chance: Floats, ratio: Floats, quantile: float | Floats = TWO_SIDED) -> tuple[Floats, Floats]:
    """Return both ends of the intervals of chances, (g,), whose variance is ``ratio`` times chance (1 - chance).

    ``quantile`` is that of the standardised estimate, by default of the normal distribution for a level of 0.95.
    """
    width = quantile**2 * ratio
    root = np.sqrt(width**2 + 4 * chance * (1 - chance) * width)
    centre, scale = 2 * chance + width, 2 * (1 + width)
    return (centre - root) / scale, (centre + root) / scale


def inference(found: Effects, level: float | Floats, freedom: float | Floats = np.inf) -> tuple[Floats, Floats, Floats]:
    """Return both ends of the interval of each mean, (g,), and the p of the test that it inverts, that it is 0.5.

    It is the test of :func:`p_values` but for two things. Quantiles are those of Student's t
    with ``freedom``. And where nearly all variance is that of runs which end lower than all runs of the rival or than
    none, as of two basins about a single one, A12 is a share of these runs, and moves in steps: then half a step is
    taken off (a continuity correction). Of 8 runs this test would err in 7.2% otherwise, at 5%. Where nothing can be
    tested p is 1, and the ends are missing.
    """
    steps = np.clip((found.ratio * (found.smaller - 1) - COUNTED) / (1 - COUNTED), 0, 1) / (2 * found.smaller)
    quantile = t.isf(np.asarray(level) / 2, freedom)
    low, _ = wilson_form(np.maximum(found.a12 - steps, 0), found.ratio, quantile)
    _, high = wilson_form(np.minimum(found.a12 + steps, 1), found.ratio, quantile)
    apart = (np.asarray(level) / 2) ** (1 / np.asarray(found.smaller))
    size = np.maximum(np.abs(found.a12 - 0.5) - steps, 0) / (0.5 * np.sqrt(found.ratio))
    p = np.maximum(2 * t.sf(size, freedom), least_p(found.smaller))
    low, high = np.minimum(low, apart), np.maximum(high, 1 - apart)
    return low, high, np.where(np.isnan(found.ratio), 1.0, p)  # a single run leaves no variance
