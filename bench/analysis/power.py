"""The smallest difference that the tests of a study would find, from its design alone."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.stats import norm

from bench.analysis.comparison import over_problems
from bench.analysis.direction import Effects, effects, inference, least_p
from bench.contract.typing import Flags

DRAWS, FEW = 20_000, 1_000  # of a simulated power, and those that find about where it is reached
VALUES = 8_000_000  # of them in memory
POWER = 0.8
STEPS = 9  # of a bisection with few draws: A12 to 0.001


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
