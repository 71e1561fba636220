"""Is a new version of an optimizer worse than the old one by more than a margin? A test of non-inferiority.

The measure is A12, the chance that a trial of the old version ends lower than one of the new version, ties counted
half: 0.5 means no tendency. With a margin of 0.05 the new version may lose up to 55% of the pairs of trials.

Two claims can be shown, and often neither is (Wellek 2010, Testing Statistical Hypotheses of Equivalence and
Noninferiority, chapter 6; Piaggio et al. 2012, JAMA 308): that A12 is above 0.5 + margin (worse), or that it is below
(not worse). A test that merely fails to reject shows nothing.

Both are asked of the mean of A12 over problems, and a mean hides a loss on one of them: with A12 = 0.7 on one of twelve
and 0.5 on the others it is 0.517. So each problem is tested, too. To be not worse on every problem is the claim of an
intersection-union test (Berger 1982, Technometrics 24; Berger and Hsu 1996, Statistical Science 11): it is made where
each problem's own test rejects at the level. No adjustment is needed, since one problem that is worse must be missed
for the claim to be false.

Tests and intervals of A12 on a problem are those of :mod:`bench.analysis.direction`, one-sided and with 0.5 + margin in
the place of 0.5. The mean over problems is that of :mod:`bench.analysis.comparison`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Literal

import numpy as np
import pandas as pd
from scipy.stats import norm

from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA, Effects, effects, intervals, stratified
from bench.analysis.pairwise import holm
from bench.analysis.strata import Samples, strata
from bench.helpers.errors import BenchError

Outcome = Literal["better", "not worse", "worse", "undecided"]

MARGIN = 0.05  # of A12
LARGEST_MARGIN = 0.5
POWER = 0.8  # of the number of trials that would decide
COLUMNS = ("problem", "n_old", "n_new", "a12", "low", "high", "p", "p_holm", "worse", "not_worse")


@dataclass(frozen=True)
class Noninferiority:
    """The comparison of a new version with an old one.

    Attributes:
        outcome: "worse" where the new version is shown to be worse by more than the margin, on average over the
            problems or on any of them, else "not worse" where that is shown on average or on ``every`` one of them, and
            "better" where it is, too, shown to end lower on average, else "undecided".
        margin: by which A12 may exceed 0.5.
        alpha: the chance of the outcome "worse" where no problem exceeds the margin, at most.
        every: whether a pass needs every problem to be shown to be not worse.
        a12: the mean over problems of the chance that a trial of the old version ends lower, ties counted half.
        low: the lower end of its interval of the level 1 - ``alpha``.
        high: the upper end.
        p: of the test that it is above 0.5 + margin, one-sided; significant at ``alpha`` / 2.
        problems: one row a problem: problem, n_old, n_new, a12, its interval low to high, the p of the same test,
            p_holm adjusted over the problems, worse (p_holm <= ``alpha`` / 2), and not_worse (high is no more than
            0.5 + margin).
        needed: about how many trials a problem would make equal versions pass with a power of 80%.
    """

    outcome: Outcome
    margin: float
    alpha: float
    every: bool
    a12: float
    low: float
    high: float
    p: float
    problems: pd.DataFrame
    needed: int

    @property
    def passed(self) -> bool:
        """Whether the new version is shown to be not worse, or better."""
        return self.outcome in ("better", "not worse")

    @property
    def bound(self) -> float:
        """The largest A12 that is not worse."""
        return 0.5 + self.margin

    @property
    def worse_overall(self) -> bool:
        """Whether the mean over problems is shown to exceed the margin."""
        return self.p <= self.alpha / 2


def noninferiority(
    frame: pd.DataFrame, old: str, new: str, margin: float = MARGIN, alpha: float = ALPHA, every: bool = False
) -> Noninferiority:
    """Compare two optimizers of a frame; see :class:`Noninferiority`.

    The new version is "worse" where the mean of A12 over problems is above 0.5 + margin at the level alpha / 2, or
    where it is on any problem at alpha / 2 after Holm's adjustment over the problems: a loss on one of twenty problems
    would not show in the mean. The chance of a false "worse" is thus at most alpha. It is "not worse"
    where the whole interval of the mean is below 0.5 + margin; with ``every``, where the interval of each problem is.
    The chance of that where the mean, or any problem, exceeds the margin is at most alpha / 2. It is "better" where
    the interval of the mean is also below 0.5, with a chance of at most alpha / 2 where the mean is not.

    Trials are independent, and problems are these ones: the interval shows how far other trials would move the mean,
    not other problems. Failed trials count as +inf, near-ties as ties. Problems without a trial of either are left out.

    Raises:
        BenchError: for a margin or level that cannot be, and where no problem has two trials of both.
    """
    both = frame[frame["optimizer"].isin([old, new])]
    place = [labels(both, "optimizer").index(label) for label in (old, new)]
    samples = {problem: [[of[each] for each in place] for of in every_of] for problem, every_of in strata(both).items()}
    return compare_samples(
        {problem: of for problem, of in samples.items() if all(len(sample) for own in of for sample in own)},
        margin, alpha, every,
    )  # fmt: skip


def compare_samples(
    samples: Mapping[str, Sequence[Samples]], margin: float = MARGIN, alpha: float = ALPHA, every: bool = False
) -> Noninferiority:
    """Compare scores of the old version, (n,), with those of the new one, (m,), by problem and stratum.

    See :func:`noninferiority`, also for what it raises, and :mod:`bench.analysis.strata`.
    """
    if not 0 < margin < LARGEST_MARGIN:
        raise BenchError(f"the margin is {margin!r}, but must be above 0 and below {LARGEST_MARGIN}, such as {MARGIN}")
    if not 0 < alpha < 1:
        raise BenchError(f"alpha is {alpha!r}, but must be above 0 and below 1, such as {ALPHA}")
    if not samples or min(len(sample) for of in samples.values() for both in of for sample in both) < 2:
        raise BenchError("there is too little to compare: every problem needs at least two trials of both versions")
    bound, level = 0.5 + margin, 1 - alpha / 2
    estimates = [
        stratified([effects(this[np.newaxis], other[np.newaxis]) for this, other in of]) for of in samples.values()
    ]
    rows = [
        (label, *(sum(map(len, own)) for own in zip(*of, strict=True)), *_inference(estimate, bound, level))
        for (label, of), estimate in zip(samples.items(), estimates, strict=True)
    ]
    problems = pd.DataFrame(rows, columns=[name for name in COLUMNS if name not in ("p_holm", "worse", "not_worse")])
    problems["p_holm"] = holm(problems["p"].to_numpy(dtype=float))
    problems["worse"] = problems["p_holm"] <= alpha / 2
    problems["not_worse"] = problems["high"] <= bound
    mean, low, high, p = _inference(stratified(estimates), bound, level)
    worse = p <= alpha / 2 or bool(problems["worse"].any())
    shown = bool(problems["not_worse"].all()) if every else high <= bound
    return Noninferiority(
        outcome="worse" if worse else "undecided" if not shown else "better" if high < 0.5 else "not worse",
        margin=margin,
        alpha=alpha,
        every=every,
        a12=mean,
        low=low,
        high=high,
        p=p,
        problems=problems,
        needed=_needed(estimates, margin, level, every),
    )


def _inference(estimate: Effects, bound: float, level: float) -> tuple[float, float, float, float]:
    """Return A12, both ends of its interval, each at the one-sided ``level``, and the p of a value above the bound."""
    (low,), (high,) = intervals(estimate, 2 * level - 1)
    size = (estimate.a12[0] - bound) / np.sqrt(estimate.ratio[0] * bound * (1 - bound))
    p = np.fmax(norm.sf(size), bound**estimate.smaller)
    return float(estimate.a12[0]), float(low), float(high), float(np.max(p))


def _needed(estimates: Sequence[Effects], margin: float, level: float, every: bool) -> int:
    """Return about how many trials a problem make equal versions pass; a variance falls as one over the trials."""
    variances = np.array([0.25 * estimate.ratio[0] * estimate.smaller for estimate in estimates])
    variance, power = (
        (variances.max(), POWER ** (1 / len(estimates))) if every else (variances.mean() / len(estimates), POWER)
    )
    return ceil(float(variance) * float((norm.ppf(level) + norm.ppf(power)) / margin) ** 2)
