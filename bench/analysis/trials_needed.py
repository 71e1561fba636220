"""Estimate how many trials of each optimizer would separate the pairs that the trials made do not separate.

A pair is separated where the report calls one optimizer separably lower: the test of A12 = 0.5 rejects
(:mod:`bench.analysis.direction`). The level is that of the next step of Holm's method, alpha over the number of pairs,
of all problems, that it does not reject yet.

The power with n trials a cell is simulated: n values are drawn from each of the two samples, with replacement (Efron
1979), so cells with two basins, or with ties, stay what they are. Of very many pairs, those with the leader are
estimated by Noether's formula for the test of Mann and Whitney (1987, Journal of the American Statistical Association
82), with both cells of one size: n = (z(1 - level / 2) + z(power))^2 / (6 (A12 - 0.5)^2).

The samples are taken for the truth, so an estimate is as uncertain as they are (Hoenig and Heisey 2001, The American
Statistician 55). The range is that of the interval of A12: by the formula n is proportional to 1 / (A12 - 0.5)^2.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.stats import norm

from bench.analysis.cells import labels
from bench.analysis.direction import ALPHA, effects_of_draws, p_values, stratified
from bench.analysis.error_rates import trials_to_separate
from bench.analysis.strata import strata
from bench.typing import Floats

POWER = 0.8
LARGEST = 1_000  # trials a cell; a pair that needs more is practically not separable
DRAWS = 400  # of a simulated power, so its standard error is 2% at most
MOST_PAIRS = 100  # open pairs up to which all are simulated
GRID = sorted({round(4 * 1.1**step) for step in range(58)} | {LARGEST})  # numbers of trials that are tried

PAIR = ("first", "second")
COLUMNS = (
    "problem", "first", "second", "n_first", "n_second", "a12", "a12_low", "a12_high", "level", "needed", "low", "high",
    "method",
)  # fmt: skip


def trials_needed(
    frame: pd.DataFrame, pairs: pd.DataFrame, standing: pd.DataFrame, *, power: float = POWER,
    alpha: float = ALPHA, seed: int = 0,
) -> pd.DataFrame:  # fmt: skip
    """Return one row a pair that is not separated: the trials of each of its optimizers that would separate it.

    Columns: problem, first, second, n_first, n_second, a12, a12_low and a12_high, as in ``pairs``; level, that of the
    test; needed, more than the trials of the smaller cell, infinite above 1,000 trials, and missing where a cell has
    fewer than two; low and high, the range of it over the interval of A12, missing where that is one point; method,
    "simulation" or "formula". No number is below that at which complete separation is significant.

    Args:
        frame: the tidy frame.
        pairs: of :func:`bench.analysis.pairwise_tests`, all pairs of each problem.
        standing: of :func:`bench.analysis.standings`; of more than 100 open pairs only those with the best optimizer of
            a problem count.
        power: the chance to separate a pair, which is to be reached.
        alpha: the level of the tests on all problems together.
        seed: of the simulation.
    """
    chosen = (pairs["lower"] == "").to_numpy(dtype=bool)
    level = alpha / max(int(chosen.sum()), 1)
    if not (simulated := chosen.sum() <= MOST_PAIRS):
        best = standing[standing["rank"] == standing.groupby("problem", observed=True)["rank"].transform("min")]
        leaders = pd.MultiIndex.from_frame(best[["problem", "optimizer"]].astype(object))
        first, second = (pd.MultiIndex.from_frame(pairs[["problem", name]].astype(object)) for name in PAIR)
        chosen = chosen & (first.isin(leaders) | second.isin(leaders))
    table = pairs[chosen].assign(level=level, method="simulation" if simulated else "formula")
    chance, low, high = (table[name].to_numpy(dtype=float) for name in ("a12", "a12_low", "a12_high"))
    smaller = table[["n_first", "n_second"]].min(axis=1).to_numpy()
    formula, fewest = noether(chance, level, power), trials_to_separate(1, level)
    needed = np.maximum(formula, np.maximum(smaller + 1.0, fewest))
    if simulated:
        by_problem, place_of = strata(frame), {name: place for place, name in enumerate(labels(frame, "optimizer"))}
        for row, pair in enumerate(table.itertuples(index=False)):
            if np.isfinite(low[row]) and noether(chance[row], alpha, power) <= LARGEST:
                both = [place_of[str(name)] for name in (pair.first, pair.second)]
                samples = [(of[both[0]], of[both[1]]) for of in by_problem[str(pair.problem)]]
                needed[row] = _simulated(samples, max(int(smaller[row]) + 1, fewest), level, power, seed)
            else:
                needed[row] = np.inf
    needed = np.where(needed > LARGEST, np.inf, needed)
    clear = (low > 0.5) | (high < 0.5)
    weakest = np.where(clear, np.minimum(np.abs(low - 0.5), np.abs(high - 0.5)), 0.0)
    strongest = np.maximum(np.abs(low - 0.5), np.abs(high - 0.5))
    scale = np.divide(needed, formula, out=np.ones(len(needed)), where=np.isfinite(needed) & np.isfinite(formula))
    least, most = (scale * noether(0.5 + end, level, power) for end in (strongest, weakest))
    ends = {
        "low": np.minimum(np.maximum(least, fewest), needed),
        "high": np.where(most > LARGEST, np.inf, np.maximum(most, needed)),
    }
    has_range, alone = np.isfinite(low), low == high  # an interval of one point shows no range
    missing = {"needed": ~has_range, "low": ~has_range | alone, "high": ~has_range | alone}
    columns = {
        name: np.where(missing[name], np.nan, np.ceil(values)) for name, values in ({"needed": needed} | ends).items()
    }
    return table.assign(**columns)[list(COLUMNS)].reset_index(drop=True)


def noether(a12: ArrayLike, level: float, power: float) -> Floats:
    """Return the trials of each of two optimizers with which the test of Mann and Whitney has a power.

    By Noether's formula for two samples of one size; infinite where A12 is 0.5. It assumes neither ties nor a
    difference in spread, and a large sample.
    """
    effect = np.asarray(a12, dtype=np.float64) - 0.5
    with np.errstate(divide="ignore"):
        return np.asarray((norm.isf(level / 2) + norm.ppf(power)) ** 2 / (6 * effect**2))


def _simulated(samples: Sequence[tuple[Floats, Floats]], fewest: int, level: float, power: float, seed: int) -> float:
    """Return the smallest number of trials in the grid, from the fewest on, with the power; infinite above all."""
    tried = [fewest, *(number for number in GRID if number > fewest)]
    place = bisect_left(tried, True, key=lambda n: power_of(samples, n, level, seed) >= power)
    return float(tried[place]) if place < len(tried) else np.inf


def power_of(samples: Sequence[tuple[Floats, Floats]], n: int, level: float, seed: int = 0) -> float:
    """Return the share of draws of n values, at least two, from each of two samples in which the pair is separated.

    The samples of a pair are by stratum (:mod:`bench.analysis.strata`), of which each has its share of the n values.
    """
    rng, each = np.random.default_rng((seed, n)), max(round(n / len(samples)), 2)
    found = []
    for this, other in samples:
        drawn, rival = (
            _times_drawn(rng.integers(0, len(sample), (DRAWS, each)), len(sample)) for sample in (this, other)
        )
        found.append(effects_of_draws(this, other, drawn, rival))
    return float(np.mean(p_values(stratified(found)) <= level))


def _times_drawn(places: NDArray[np.int64], size: int) -> Floats:
    """Return how often each of a number of values is drawn, (g, size), by the places of those drawn, (g, n)."""
    rows = size * np.arange(len(places))[:, np.newaxis]
    counts = np.bincount((rows + places).ravel(), minlength=size * len(places))
    return counts.reshape(len(places), size).astype(np.float64)
