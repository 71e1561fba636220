"""Is a new version of an optimizer worse than the old one by more than a margin? A test of non-inferiority.

The measure is A12, the chance that a trial of the old version ends lower than one of the new version, ties counted
half: 0.5 means no tendency. With a margin of 0.05 the new version may lose up to 55 % of the pairs of trials.

Two claims can be shown, and often neither is (Wellek 2010, Testing Statistical Hypotheses of Equivalence and
Noninferiority, chapter 6; Piaggio et al. 2012, JAMA 308): that A12 is above 0.5 + margin (worse), or that it is below
(not worse). A test that merely fails to reject shows nothing.

Both are asked of the mean of A12 over problems, and a mean hides a loss on one of them: with A12 = 0.7 on one of twelve
and 0.5 on the others it is 0.517. So each problem is tested, too. To be not worse on every problem is the claim of an
intersection-union test (Berger 1982, Technometrics 24; Berger and Hsu 1996, Statistical Science 11): it is made where
each problem's own test rejects at the level. No adjustment is needed, since one problem that is worse must be missed
for the claim to be false.

The interval of A12 is that of DeLong, DeLong and Clarke-Pearson (1988, Biometrics 44) and Brunner and Munzel (2000,
Biometrical Journal 42), on the logit scale: the variance of each sample's placements in the other one, and Student's t
with Satterthwaite's degrees of freedom. That variance is 0 where all trials tie or are separated, as if so few trials
were certain. So it is computed a second time with a trial added to each sample that is better, and one that is worse,
than all others, in the way of Agresti and Caffo (2000, The American Statistician 54), and the larger one counts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
from scipy.special import expit, logit
from scipy.stats import norm, rankdata, t

from bench.analysis.cells import cells, labels
from bench.analysis.pairwise import ALPHA, a12, holm, wins
from bench.errors import BenchError
from bench.problem import Floats

Outcome = Literal["pass", "worse", "undecided"]

MARGIN = 0.05  # of A12
LARGEST_MARGIN = 0.5
POWER = 0.8  # of the number of trials that would decide
COLUMNS = ("problem", "n_old", "n_new", "a12", "low", "high", "p", "p_holm", "worse", "not_worse")


@dataclass(frozen=True)
class Noninferiority:
    """The comparison of a new version with an old one.

    Attributes:
        outcome: "pass" where the new version is shown to be not worse, on average over the problems or on ``every``
            one of them, "worse" where it is shown to be worse by more than the margin, on average or on any problem,
            else "undecided".
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
        needed: about how many trials a problem would make equal versions pass with a power of 80 %.
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
    would not show in the mean. The chance of a false "worse" is thus at most alpha. It is a "pass" where it is not
    worse and the whole interval of the mean is below 0.5 + margin; with ``every``, where the interval of each problem
    is. The chance of a pass where the mean, or any problem, exceeds the margin is at most alpha / 2.

    Trials are independent, and problems are these ones: the interval shows how far other trials would move the mean,
    not other problems. Failed trials count as +inf, near-ties as ties. Problems without a trial of either are left out.

    Raises:
        BenchError: for a margin or level that cannot be, and where no problem has two trials of both.
    """
    found = cells(frame, merge=True)
    samples = {each: (found[each, old], found[each, new]) for each in labels(frame, "problem")}
    return compare_samples(
        {each: both for each, both in samples.items() if min(map(len, both)) > 0}, margin, alpha, every
    )


def compare_samples(
    samples: Mapping[str, tuple[Floats, Floats]], margin: float = MARGIN, alpha: float = ALPHA, every: bool = False
) -> Noninferiority:
    """Compare scores of the old version, (n,), with those of the new one, (m,), by problem; see :func:`noninferiority`.

    Raises:
        BenchError: as :func:`noninferiority`.
    """
    if not 0 < margin < LARGEST_MARGIN:
        raise BenchError(f"the margin is {margin!r}, but must be above 0 and below {LARGEST_MARGIN}, such as {MARGIN}")
    if not 0 < alpha < 1:
        raise BenchError(f"alpha is {alpha!r}, but must be above 0 and below 1, such as {ALPHA}")
    if not samples or min(min(map(len, both)) for both in samples.values()) < 2:
        raise BenchError("there is too little to compare: every problem needs at least two trials of both versions")
    bound, level = 0.5 + margin, 1 - alpha / 2
    rows, spreads = [], []
    for label, (this, other) in samples.items():
        chance, spread = a12(this, other), _spread(this, other)
        rows.append((label, len(this), len(other), chance, *_inference(chance, spread, bound, level)))
        spreads.append(spread)
    problems = pd.DataFrame(rows, columns=[name for name in COLUMNS if name not in ("p_holm", "worse", "not_worse")])
    problems["p_holm"] = holm(problems["p"].to_numpy(dtype=float))
    problems["worse"] = problems["p_holm"] <= alpha / 2
    problems["not_worse"] = problems["high"] <= bound
    mean, spread = float(problems["a12"].mean()), _mean_spread(spreads)
    low, high, p = _inference(mean, spread, bound, level)
    worse = p <= alpha / 2 or bool(problems["worse"].any())
    shown = bool(problems["not_worse"].all()) if every else high <= bound
    return Noninferiority(
        outcome="worse" if worse else "pass" if shown else "undecided",
        margin=margin,
        alpha=alpha,
        every=every,
        a12=mean,
        low=low,
        high=high,
        p=p,
        problems=problems,
        needed=_needed(problems, [each.variance for each in spreads], margin, level, every),
    )


def _needed(problems: pd.DataFrame, variances: list[float], margin: float, level: float, every: bool) -> int:
    """Return about how many trials a problem make equal versions pass; a variance falls as one over the trials."""
    each = problems[["n_old", "n_new"]].min(axis=1).to_numpy() * variances
    variance, power = (each.max(), POWER ** (1 / len(each))) if every else (each.mean() / len(each), POWER)
    return ceil(float(variance) * float((norm.ppf(level) + norm.ppf(power)) / margin) ** 2)


class _Spread(NamedTuple):
    """The spread of an estimate of A12.

    Attributes:
        variance: the variance.
        squares: the sum of its squared parts over their degrees of freedom (Satterthwaite 1946).
        edge: how close to 0 or 1 the estimate counts as being; that of separated samples with the trials added.
    """

    variance: float
    squares: float
    edge: float


def _spread(this: Floats, other: Floats) -> _Spread:
    """Return the spread of A12, the larger one of the trials as they are and with a best and a worst one added."""
    ranks = rankdata(np.concatenate((this, other)), method="dense")
    ends = [0.0, ranks.max() + 1]
    first, second = ranks[: len(this)], ranks[len(this) :]
    plain, (n, m) = _placements(first, second), (len(first), len(second))
    added = _placements(np.append(first, ends), np.append(second, ends))
    edge = (n + m + 2) / ((n + 2) * (m + 2))
    return _Spread(*max(plain, added), edge)


def _placements(first: Floats, second: Floats) -> tuple[float, float]:
    """Return variance and squares of A12, from the variance of the placements of each sample in the other."""
    won = wins(first, second)
    parts = [(won.mean(axis=axis).var(ddof=1) / won.shape[1 - axis], won.shape[1 - axis] - 1) for axis in (1, 0)]
    return float(sum(part for part, _ in parts)), float(sum(part**2 / freedom for part, freedom in parts))


def _mean_spread(spreads: list[_Spread]) -> _Spread:
    """Return the spread of the mean of independent estimates."""
    variance, squares, edge = np.sum(spreads, axis=0)
    number = len(spreads)
    return _Spread(float(variance) / number**2, float(squares) / number**4, float(edge) / number)


def _inference(chance: float, spread: _Spread, bound: float, level: float) -> tuple[float, float, float]:
    """Return both ends of the interval, each at the one-sided ``level``, and the p of a value above the bound."""
    freedom = spread.variance**2 / spread.squares
    inside = min(max(chance, spread.edge), 1 - spread.edge)  # the logit of 0 and of 1 is infinite
    error = spread.variance**0.5 / (inside * (1 - inside))
    reach = float(t.ppf(level, freedom)) * error
    low, high = (float(expit(logit(inside) + side * reach)) for side in (-1, 1))
    p = float(t.sf((logit(inside) - logit(bound)) / error, freedom))
    return min(low, chance), max(high, chance), p
