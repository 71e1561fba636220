"""How often a comparison would claim a difference where there is none, and the smallest difference that it would find.

Two worlds without any difference are simulated for the design of a study. In the first, the optimizers are identical:
the trials of each problem are dealt out to them at random, so ties and basins stay. In the second, A12 is 0.5 for every
pair, and the spread doubles from one optimizer to the next: normal values of one mean.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from bench.analysis.across import signed_ranks
from bench.analysis.direction import ALPHA, Effects, effects, least_p, p_values, standardised
from bench.typing import Flags, Floats

STUDIES = (40, 1_000)  # that are simulated, at least and at most
WORK = 20_000_000  # values of pairs of samples in all: a few seconds
AT_ONCE = 1_000_000  # of them in memory
DRAWS = 1_000  # of a simulated power
POWER = 0.8
STEPS = 9  # of a bisection: A12 to 0.001


class Levels(NamedTuple):
    """The levels of the tests, which the design of a study gives.

    Attributes:
        problems: of the tests on single problems; 0 where none can be significant.
        across: of the tests over all problems; likewise.
        further: whether these are tests across blocks, which speak of further problems, and not of the mean over these
            problems (:func:`bench.analysis.wilcoxon_tests`, :func:`bench.analysis.stratified_tests`).
    """

    problems: float
    across: float
    further: bool = True


class Rates(NamedTuple):
    """The shares of simulated studies that claim a difference.

    Attributes:
        studies: how many were simulated.
        problems: the share with any optimizer separably lower than another on any problem.
        across: the share with any significant difference across problems.
        any: the share with one or the other.
    """

    studies: int
    problems: float
    across: float
    any: float


def levels(sizes: Sequence[int], pairs: int, tests: int, blocks: int, alpha: float = ALPHA) -> Levels:
    """Divide ``alpha`` between the tests on problems and those across problems, by the design alone.

    Each part gets half where both can reject at half, and all of it goes to one part otherwise, to that over all
    problems where it can reject: so all claims together err with ``alpha`` at most. The tests over all problems are
    those across blocks where these are enough for one to reject, and else, on two problems or more, those of the mean
    over these problems.

    Args:
        sizes: the trials of the smaller cell of each pair, by problem.
        pairs: of optimizers.
        tests: pairs times problems.
        blocks: independent problems (:mod:`bench.analysis.across`).
        alpha: the level of all claims.
    """
    on_problems = float(least_p(max(sizes, default=0))) * max(tests, 1)
    across = float(2.0 ** (1 - blocks) * max(pairs, 1))  # where all blocks have one sign
    further = across <= alpha / 2
    over = across if further else 1.0
    if not further and len(sizes) > 1 and min(sizes) > 1:
        over = float(least_p(sum(sizes))) * max(pairs, 1)
    if max(on_problems, over) <= alpha / 2:
        return Levels(alpha / 2, alpha / 2, further)
    if over <= alpha / 2:  # a part that can reject at complete separation only must not silence the other one
        return Levels(0.0, alpha, further)
    return Levels(alpha if on_problems <= alpha else 0.0, 0.0, further)


def rates_of_equals(
    pools: Sequence[Floats], optimizers: int, blocks: Sequence[str], level: Levels, seed: int = 0
) -> Rates:
    """Return the rates where the optimizers are identical.

    Args:
        pools: the scores of all trials of each problem, at least two an optimizer.
        optimizers: k.
        blocks: the block of each problem.
        level: of the tests.
        seed: of the simulation.
    """
    trials = min(len(pool) for pool in pools) // optimizers
    rng = np.random.default_rng(seed)

    def draw(studies: int) -> Floats:
        dealt = [rng.permuted(np.tile(pool, (studies, 1)), axis=1)[:, : trials * optimizers] for pool in pools]
        return np.stack(dealt, axis=1).reshape(studies, len(pools), optimizers, trials)

    return _rates(draw, (len(pools), optimizers, trials), blocks, level)


def rates_of_spreads(trials: int, optimizers: int, blocks: Sequence[str], level: Levels, seed: int = 0) -> Rates:
    """Return the rates where A12 is 0.5 for every pair and the spread doubles from one optimizer to the next."""
    rng, spread = np.random.default_rng(seed), np.ldexp(1.0, np.arange(optimizers) % 1000)
    shape = len(blocks), optimizers, trials
    return _rates(lambda studies: rng.standard_normal((studies, *shape)) * spread[:, np.newaxis], shape, blocks, level)


def _rates(draw: Callable[[int], Floats], shape: tuple[int, int, int], blocks: Sequence[str], level: Levels) -> Rates:
    problems, optimizers, trials = shape
    one, other = np.triu_indices(optimizers, 1)
    work = problems * len(one) * 2 * trials
    studies = int(np.clip(WORK // work, *STUDIES))
    owner = np.unique(np.array(blocks), return_inverse=True)[1]
    weights = (owner == np.arange(owner.max() + 1)[:, np.newaxis]).astype(float)
    weights /= weights.sum(axis=1, keepdims=True)
    claimed = np.zeros((2, studies), dtype=bool)
    at_once = max(AT_ONCE // work, 1)
    for start in range(0, studies, at_once):
        values = draw(min(at_once, studies - start))
        effect = effects(*(values[:, :, places].reshape(-1, trials) for places in (one, other)))
        p, chance, ratio = (
            of_pairs.reshape(len(values), problems, len(one))
            for of_pairs in (p_values(effect), effect.a12, effect.ratio)
        )
        means = np.round(weights @ (chance - 0.5), 12)
        size = np.abs(standardised(chance, ratio, axis=1))
        now = slice(start, start + len(values))
        claimed[0, now] = p.min(axis=(1, 2)) * p[0].size <= level.problems
        if level.further:
            claimed[1, now] = [_across(study_means, level.across) for study_means in means]
        else:
            claimed[1, now] = 2 * norm.sf(size.max(axis=1)) * len(one) <= level.across
    return Rates(studies, *(float(claims.mean()) for claims in (*claimed, claimed.any(axis=0))))


def _across(means: Floats, level: float) -> bool:
    """Return whether any pair differs across blocks; ``means`` are A12 - 0.5, (blocks, pairs)."""
    if level <= 0:
        return False
    return bool(min(signed_ranks(pair_means, level)["p"] for pair_means in means.T) * means.shape[1] <= level)


@lru_cache
def detectable_a12(trials: int, level: float, power: float = POWER) -> float:
    """Return the smallest A12 that the test on a problem finds with a power; NaN where it finds none.

    Assumes two normal samples of one spread, and simulates 1,000 pairs.
    """
    if trials < 2 or least_p(trials) > level:
        return float("nan")
    return _smallest(DRAWS, trials, power, lambda effect: p_values(effect) <= level)


@lru_cache
def detectable_across(trials: int, blocks: int, level: float, further: bool = True, power: float = POWER) -> float:
    """Return the smallest A12, the same on every problem, that the test over problems finds; NaN where it finds none.

    Assumes as :func:`detectable_a12` does, and blocks of one problem, or as many problems where the test is not of
    ``further`` ones.
    """
    if further and 2.0 ** (1 - blocks) > level:
        return float("nan")
    draws = max(DRAWS // blocks, 200)

    def rejects(effect: Effects) -> Flags:
        means = effect.a12.reshape(draws, blocks) - 0.5
        if not further:
            size = standardised(means + 0.5, effect.ratio.reshape(draws, blocks), axis=1)
            return np.asarray(2 * norm.sf(size) <= level)
        return np.array([signed_ranks(draw, level)["p"] <= level for draw in means])

    return _smallest(draws * blocks, trials, power, rejects)


def _smallest(pairs: int, trials: int, power: float, rejects: Callable[[Effects], Flags]) -> float:
    """Return the smallest A12 of pairs of samples with which a test rejects often enough; NaN where there is none."""
    this, other = np.random.default_rng(20_250_101).standard_normal((2, pairs, trials))

    def is_found(chance: float) -> bool:
        shift = np.sqrt(2) * norm.ppf(chance)
        return bool(np.mean(rejects(effects(this, other + shift))) >= power)

    low, high = 0.5, 1.0 - 1e-6
    if not is_found(high):
        return float("nan")
    for _ in range(STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if is_found(middle) else (middle, high)
    return high


def trials_to_separate(tests: int, level: float) -> int:
    """Return the trials a cell from which on complete separation is significant beside as many tests."""
    return 1 + int(np.ceil(np.log2(max(tests, 1) / level)))
