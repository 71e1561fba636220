"""The smallest difference that the tests of a study would find, from its design alone, and the levels of its tests."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from bench.analysis.comparison import inference, over_problems
from bench.analysis.direction import ALPHA, Effects, effects, least_p
from bench.typing import Flags

DRAWS, FEW = 20_000, 1_000  # of a simulated power, and those that find about where it is reached
VALUES = 8_000_000  # of them in memory
POWER = 0.8
STEPS = 9  # of a bisection with few draws: A12 to 0.001

ON_PROBLEMS = 0.01  # of the level of all claims of a page
COURSE = 0.005


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
