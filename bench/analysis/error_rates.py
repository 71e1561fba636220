"""How often a comparison would claim a difference where there is none, and the smallest difference that it would find.

Two worlds without any difference are simulated for the design of a study. In the first, the optimizers are identical:
the trials of each problem are dealt out to them at random, so ties and basins stay. In the second, A12 is 0.5 for every
pair, and the spread doubles from one optimizer to the next: normal values of one mean.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import norm

from bench.analysis.across import p_of_means
from bench.analysis.comparison import inference, over_problems
from bench.analysis.direction import ALPHA, Effects, effects, least_p, mean_of, p_values, stacked, stratified
from bench.analysis.pairwise import holm
from bench.typing import Flags, Floats

MOST = 12  # optimizers that are simulated
STUDIES = (40, 1_000)  # that are simulated, at least and at most
WORK = 50_000_000  # values of pairs of samples in all: a few seconds
DRAWS, FEW = 20_000, 1_000  # of a simulated power, and those that find about where it is reached
VALUES = 8_000_000  # of them in memory
POWER = 0.8
STEPS = 9  # of a bisection with few draws: A12 to 0.001

ON_PROBLEMS = 0.01  # of the level of all claims of a page
COURSE = 0.005

Stratum = Sequence[Floats]  # the values of k optimizers on one instance, (studies, n) each
Parts = Sequence[Sequence[int]]  # the places of the problems of each part


class Levels(NamedTuple):
    """The levels of the tests, which the design of a study gives.

    Attributes:
        problems: of the tests on single problems; 0 where none can be significant.
        across: of the tests over all problems, and of the winner; likewise.
        course: of the statement on who leads at smaller budgets.
    """

    problems: float
    across: float
    course: float = 0.0

    def in_parts(self, opened: ArrayLike) -> Floats:
        """Return the level of the tests of a subject in parts of the problems and at smaller budgets.

        It is that of the course. Where the gate is ``opened``, because every test over all problems rejects, these pass
        their level on: a family of hypotheses after the one that guards it (Bretz, Maurer, Brannath and Posch 2009).
        """
        return self.course + self.across * np.asarray(opened, dtype=np.float64)


class ClaimRates(NamedTuple):
    """The shares of simulated studies that claim a difference.

    Attributes:
        studies: how many were simulated.
        problems: the share with any optimizer separably lower than another on any problem.
        across: the share with a winner, or any significant difference over all problems.
        any: the share with one or the other.
    """

    studies: int
    problems: float
    across: float
    any: float


def levels(sizes: Sequence[int], pairs: int, tests: int, alpha: float = ALPHA) -> Levels:
    """Divide ``alpha`` between the tests on problems, those over all problems and the course, by the design alone.

    So all claims of a page together err with ``alpha`` at most. Where no test on a problem could be significant, and
    where there is one problem, on which both kinds of tests are the same, the tests over all problems have the level
    of both.

    Args:
        sizes: the trials of the smaller cell of each pair, by problem.
        pairs: of optimizers.
        tests: pairs times problems.
        alpha: the level of all claims.
    """
    course = alpha * COURSE / ALPHA
    on_problems, both = alpha * ON_PROBLEMS / ALPHA, alpha - course
    if min(sizes, default=0) < 2 or not _can_reject(len(sizes) * min(sizes), pairs, both):
        # Problems with few trials take from the bound of all: those with many may still be tested.
        return Levels(both if _can_reject(max(sizes, default=0), tests, both) else 0.0, 0.0, course)
    if len(sizes) == 1:
        return Levels(both, both, course)
    if not _can_reject(max(sizes), tests, on_problems):
        return Levels(0.0, both, course)
    return Levels(on_problems, both - on_problems, course)


def enough_trials(problems: int, pairs: int, tests: int) -> tuple[int, float]:
    """Return the trials a cell from which on a test on a problem can be significant, and the level that it then has.

    Arguments are those of :func:`levels`, for the same number of trials on each of the ``problems``.
    """
    found = ((n, levels([n] * max(problems, 1), pairs, tests).problems) for n in itertools.count(1))
    return next((n, level) for n, level in found if level)


def _can_reject(trials: int, tests: int, level: float) -> bool:
    """Return whether complete separation of this number of trials is significant beside this number of tests."""
    return bool(least_p(trials) * max(tests, 1) <= level)


def rates_of_equals(
    pools: Sequence[Sequence[Floats]], optimizers: int, level: Levels, seed: int = 0, parts: Parts | None = None
) -> ClaimRates:
    """Return the rates where the optimizers are identical.

    Args:
        pools: the scores of all trials of each problem, by instance: at least two an optimizer.
        optimizers: k; of more than twelve, twelve are simulated, which have the trials of all to draw from.
        level: of the tests.
        seed: of the simulation.
        parts: of the problems; where they are given, the first optimizer is a subject, as of :func:`claims`.
    """
    rng, k = np.random.default_rng(seed), min(optimizers, MOST)
    studies = _studies(k, sum(len(pool) for strata in pools for pool in strata) / optimizers)

    def dealt(pool: Floats) -> Stratum:
        trials = len(pool) // optimizers
        values = rng.permuted(np.tile(pool, (studies, 1)), axis=1)[:, : trials * k]
        return list(values.reshape(studies, k, trials).transpose(1, 0, 2))

    return _rates(([dealt(pool) for pool in strata] for strata in pools), level, parts)


def rates_of_spreads(
    trials: int, optimizers: int, problems: int, level: Levels, seed: int = 0, parts: Parts | None = None
) -> ClaimRates:
    """Return the rates where A12 is 0.5 for every pair and the spread doubles from one optimizer to the next."""
    rng, k = np.random.default_rng(seed), min(optimizers, MOST)
    studies = _studies(k, trials * problems)
    return _rates(
        ([[2.0**place * rng.standard_normal((studies, trials)) for place in range(k)]] for _ in range(problems)),
        level,
        parts,
    )


def _studies(optimizers: int, trials: float) -> int:
    return int(np.clip(WORK // (trials * optimizers * max(optimizers - 1, 1)), *STUDIES))


def _rates(problems: Iterable[Sequence[Stratum]], level: Levels, parts: Parts | None) -> ClaimRates:
    on_problem, over_all, winner = claims(problems, level, parts=parts)
    claimed = on_problem, over_all | winner, on_problem | over_all | winner
    return ClaimRates(len(on_problem), *(float(flags.mean()) for flags in claimed))


def claims(
    problems: Iterable[Sequence[Stratum]], level: Levels, tied: int | None = None, parts: Parts | None = None
) -> tuple[Flags, Flags, Flags]:
    """Return three flags (studies,): a claim on any problem, a claim over all problems, a winner.

    The claims are those of a report: by Holm's method any difference is claimed where the smallest p is, and a winner
    needs no adjustment, since all of its tests must reject. With ``parts`` the first optimizer is a subject: only its
    pairs are tested, and the third claim is a difference over all problems of any part, in place of a winner.

    Args:
        problems: the strata of each problem, its instances or itself.
        level: of the tests.
        tied: the number of optimizers, the first ones, between which a claim is false; all, unless given.
        parts: the places of the problems of each part, such as a class of functions.
    """
    found = [stratified([_pairs(stratum, parts is not None) for stratum in strata]) for strata in problems]
    estimates = stacked(found)  # (problems, pairs, studies)
    number, pairs, _ = estimates.a12.shape
    optimizers = 1 + (int(np.sqrt(2 * pairs)) if parts is None else pairs)  # whose pairs these are
    rivals = [pair for pair in itertools.combinations(range(optimizers), 2) if parts is None or not pair[0]]
    equal = np.array([second < (tied or optimizers) for _, second in rivals])
    alone = p_values(estimates)
    on_problem = _holm(alone.reshape(-1, alone.shape[2]), np.tile(equal, number), level.problems)
    p, mean = p_of_means(estimates), mean_of(estimates).a12.round(12)
    over_all, shown = _holm(p, equal, level.across), p <= level.across
    if parts is not None:
        a12, ratio, smaller = map(np.asarray, estimates)
        of_parts = [Effects(*(each[list(places)] for each in (a12, ratio, smaller))) for places in parts]
        every = [p_of_means(of_part) for of_part in of_parts]
        none = np.zeros_like(over_all)
        steps = np.sort(p, axis=0) * np.arange(len(p), 0, -1)[:, np.newaxis]
        opened = level.in_parts((steps <= level.across).all(axis=0))
        where = _holm(np.concatenate(every), np.tile(equal, len(every)), opened) if every else none
        return on_problem, over_all, where
    won = np.zeros((optimizers, p.shape[1]), dtype=np.int64)
    for place, (first, second) in enumerate(rivals):
        won[first] += shown[place] & (mean[place] > 0.5)
        won[second] += shown[place] & (mean[place] < 0.5)
    return on_problem, over_all, (won == optimizers - 1).any(axis=0)


def _holm(p: Floats, equal: Flags, level: float | Floats) -> Flags:
    """Return in which studies Holm's method rejects any of the ``equal`` pairs, from p-values of (pairs, studies).

    ``level`` may differ by study.
    """
    if equal.all():  # it begins with the smallest
        return np.asarray(p.min(axis=0) * len(p) <= level)
    levels_of = np.broadcast_to(level, p.shape[1:])
    return np.array([bool((holm(own)[equal] <= at).any()) for own, at in zip(p.T, levels_of, strict=True)])


def _pairs(stratum: Stratum, of_first: bool) -> Effects:
    """Return A12 of each pair of optimizers, or of the first with each other one, in each study, (pairs, studies)."""
    pairs = ((stratum[0], other) for other in stratum[1:]) if of_first else itertools.combinations(stratum, 2)
    return stacked([effects(one, other) for one, other in pairs])


@lru_cache
def detectable_a12(trials: int, level: float, power: float = POWER) -> float:
    """Return the smallest A12 that the test on a problem finds with a power; NaN where it finds none.

    Assumes two normal samples of one spread. The power is simulated, so that A12 has an error of 0.001.
    """
    if trials < 2 or least_p(trials) > level:
        return float("nan")
    return _smallest(1, trials, power, _on_a_problem(level))


@lru_cache
def detectable_across(trials: int, problems: int, level: float, power: float = POWER) -> float:
    """Return the smallest A12, the same on every problem, that the test over them finds; NaN where it finds none.

    Assumes and simulates as :func:`detectable_a12` does.
    """
    return _smallest(problems, trials, power, _over(problems, trials, level))


def power_at(a12: float, trials: int, level: float, problems: int = 0) -> float:
    """Return the power of the test on a problem, or of the one over some problems, at an A12 that is the same on each.

    Assumes as :func:`detectable_a12` does; simulated with a standard error of 0.013 at most.
    """
    rejects = _over(problems, trials, level) if problems else _on_a_problem(level)
    draws = FEW * 3 // 2
    this, other = np.random.default_rng(20_250_101).standard_normal((2, max(problems, 1) * draws, trials))
    return float(np.mean(rejects(effects(this, other + np.sqrt(2) * norm.ppf(a12)))))


def _on_a_problem(level: float) -> Callable[[Effects], Flags]:
    return lambda effect: np.asarray(inference(effect, level)[2] <= level)


def _over(problems: int, trials: int, level: float) -> Callable[[Effects], Flags]:
    def rejects(effect: Effects) -> Flags:
        a12, ratio = (values.reshape(problems, -1) for values in (effect.a12, effect.ratio))
        mean = over_problems([[Effects(*each, trials)] for each in zip(a12, ratio, strict=True)])
        return np.asarray(inference(mean, level)[2] <= level)

    return rejects


def _smallest(problems: int, trials: int, power: float, rejects: Callable[[Effects], Flags]) -> float:
    """Return the smallest A12 with which a test rejects often enough; NaN where there is none.

    Few draws find about where that is, and all of them then interpolate.
    """
    few, draws = (max(number // problems, number // 5) for number in (FEW, DRAWS))
    draws = max(few, min(draws, VALUES // (problems * trials)))
    this, other = np.random.default_rng(20_250_101).standard_normal((2, problems, draws, trials))

    def found(chance: float, draws: int) -> float:
        shift = np.sqrt(2) * norm.ppf(chance)
        pairs = (values[:, :draws].reshape(-1, trials) for values in (this, other + shift))
        return float(np.mean(rejects(effects(*pairs))))

    low, high = 0.5, (most := 1.0 - 1e-6)
    if found(most, few) < power:
        return float("nan")
    for _ in range(STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if found(middle, few) >= power else (middle, high)
    step = 0.02
    while step > 1e-3 and found(high - step, few) < power - 0.1:
        step /= 2
    ends = max(high - step, 0.5), min(high + step, most)
    return float(np.interp(power, [found(end, draws) for end in ends], ends))


def trials_to_separate(tests: int, level: float) -> int:
    """Return the trials a cell from which on complete separation is significant beside as many tests."""
    return 1 + int(np.ceil(np.log2(max(tests, 1) / level)))
