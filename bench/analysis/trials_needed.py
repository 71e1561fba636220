"""Estimate how many trials of each optimizer would separate the pairs that the trials made do not separate.

A pair is separated where the report calls one optimizer separably lower: the Kolmogorov-Smirnov test rejects at its
level, and the 95 % interval of A12 excludes 0.5. The level is that of the next step of Holm's method, alpha over the
number of pairs of the problem that it does not reject yet.

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
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.stats import norm

from bench.analysis.cells import cells
from bench.analysis.pairwise import ALPHA, TIED, critical_distance, tied_critical_distance, tied_share, wins
from bench.analysis.sequential import levels
from bench.problem import Floats

POWER = 0.8
LARGEST = 1_000  # trials a cell; a pair that needs more is practically not separable
DRAWS = 400  # of a simulated power, so its standard error is 2 % at most
MOST_PAIRS = 100  # open pairs up to which all are simulated
EXACT_TIES = 60  # trials up to which the critical distance given ties is exact
GRID = sorted({round(4 * 1.1**step) for step in range(58)} | {LARGEST})  # numbers of trials that are tried

PAIR = ("first", "second")
COLUMNS = (
    "problem", "first", "second", "n_first", "n_second", "a12", "a12_low", "a12_high", "level", "needed", "low", "high",
    "method",
)  # fmt: skip


def trials_needed(
    frame: pd.DataFrame, pairs: pd.DataFrame, standing: pd.DataFrame, *, power: float = POWER,
    alpha: float = ALPHA, looks: Sequence[int] = (), seed: int = 0,
) -> pd.DataFrame:  # fmt: skip
    """Return one row a pair that is not separated: the trials of each of its optimizers that would separate it.

    Columns: problem, first, second, n_first, n_second, a12, a12_low and a12_high, as in ``pairs``; level, that of the
    test; needed, more than the trials of the smaller cell, infinite above 1,000 trials, and missing where a cell has
    fewer than two; low and high, the range of it over the interval of A12, missing where that is one point; method,
    "simulation" or "formula".

    Args:
        frame: the tidy frame.
        pairs: of :func:`bench.analysis.pairwise_tests`, all pairs of each problem.
        standing: of :func:`bench.analysis.standings`; of more than 100 open pairs only those with the best optimizer of
            a problem count.
        power: the chance to separate a pair, which is to be reached.
        alpha: the level of the tests of a problem.
        looks: the study's declared looks: the level of a pair is then that of the last one.
        seed: of the simulation.
    """
    left = ~pairs["significant"].astype(bool)
    number = left.groupby(pairs["problem"], observed=True).transform("sum").clip(lower=1)
    steps = {int(each): alpha / int(each) for each in number.unique()}
    if looks:
        steps = {each: levels(tuple(looks), step)[-1] for each, step in steps.items()}
    chosen = (left | (pairs["lower"] == "")).to_numpy(dtype=bool)
    if not (simulated := chosen.sum() <= MOST_PAIRS):
        best = standing[standing["rank"] == standing.groupby("problem", observed=True)["rank"].transform("min")]
        chosen = chosen & _holds_one(pairs, best)
    table = pairs[chosen].assign(level=number[chosen].map(steps))
    table = table.assign(method="simulation" if simulated else "formula")
    chance, low, high = (table[name].to_numpy(dtype=float) for name in ("a12", "a12_low", "a12_high"))
    level, smaller = table["level"].to_numpy(dtype=float), table[["n_first", "n_second"]].min(axis=1).to_numpy()
    formula = noether(chance, level, power)
    needed = np.maximum(formula, smaller + 1.0)
    if simulated:
        found = cells(frame, merge=True)
        for row, pair in enumerate(table.itertuples(index=False)):
            if np.isfinite(low[row]) and noether(chance[row], alpha, power) <= LARGEST:
                both = found[str(pair.problem), str(pair.first)], found[str(pair.problem), str(pair.second)]
                needed[row] = _simulated(*both, int(smaller[row]), float(level[row]), power, seed)
            else:
                needed[row] = np.inf
    needed = np.where(needed > LARGEST, np.inf, needed)
    clear = (low > 0.5) | (high < 0.5)
    weakest = np.where(clear, np.minimum(np.abs(low - 0.5), np.abs(high - 0.5)), 0.0)
    strongest = np.maximum(np.abs(low - 0.5), np.abs(high - 0.5))
    scale = np.divide(needed, formula, out=np.ones(len(needed)), where=np.isfinite(needed) & np.isfinite(formula))
    least, most = (scale * noether(0.5 + end, level, power) for end in (strongest, weakest))
    ends = {"low": np.minimum(least, needed), "high": np.where(most > LARGEST, np.inf, np.maximum(most, needed))}
    known, alone = np.isfinite(low), low == high  # an interval of one point shows no range
    missing = {"needed": ~known, "low": ~known | alone, "high": ~known | alone}
    columns = {
        name: np.where(missing[name], np.nan, np.ceil(values)) for name, values in ({"needed": needed} | ends).items()
    }
    return table.assign(**columns)[list(COLUMNS)].reset_index(drop=True)


def _holds_one(pairs: pd.DataFrame, best: pd.DataFrame) -> NDArray[np.bool_]:
    """Return whether each pair holds an optimizer that is listed as ``best`` on its problem."""
    problems, optimizers = (list(dict.fromkeys(best[name])) for name in ("problem", "optimizer"))
    listed = np.zeros((len(problems) + 1, len(optimizers) + 1), dtype=bool)  # the last ones are of none, of code -1
    listed[_codes(best["problem"], problems), _codes(best["optimizer"], optimizers)] = True
    problem = _codes(pairs["problem"], problems)
    first, second = (listed[problem, _codes(pairs[name], optimizers)] for name in PAIR)
    return np.asarray(first | second)


def _codes(labels: pd.Series[str], known: list[str]) -> NDArray[np.intp]:
    return np.asarray(labels.astype("category").cat.set_categories(known).cat.codes, dtype=np.intp)


def noether(a12: ArrayLike, level: ArrayLike, power: float) -> Floats:
    """Return the trials of each of two optimizers with which the test of Mann and Whitney has a power.

    By Noether's formula for two samples of one size; infinite where A12 is 0.5. It assumes neither ties nor a
    difference in spread, and a large sample.
    """
    effect = np.asarray(a12, dtype=np.float64) - 0.5
    with np.errstate(divide="ignore"):
        return np.asarray((norm.isf(np.asarray(level) / 2) + norm.ppf(power)) ** 2 / (6 * effect**2))


class _Pair(NamedTuple):
    """Two samples as a simulation draws from them."""

    this: Floats
    other: Floats
    won: Floats  # (n, m) wins of the one against the other
    order: NDArray[np.intp]  # of all values
    last: NDArray[np.bool_]  # whether a value is the last of equal ones, in that order
    spread: float  # n times the variance of A12 with n trials a cell
    tied: bool


def _simulated(this: Floats, other: Floats, trials: int, level: float, power: float, seed: int) -> float:
    """Return the smallest number of trials in the grid, above those made, with the power; infinite above all."""
    won = wins(this, other)
    pooled = np.concatenate((this, other))
    order = np.argsort(pooled, kind="stable")
    last = np.append(pooled[order][1:] != pooled[order][:-1], True)
    spread = float(won.mean(axis=1).var(ddof=1) + won.mean(axis=0).var(ddof=1))
    pair = _Pair(this, other, won, order, last, spread, tied_share(pooled) > TIED)
    tried = [trials + 1, *(each for each in GRID if each > trials + 1)]
    place = bisect_left(tried, True, key=lambda n: power_of(pair, n, level, seed) >= power)
    return float(tried[place]) if place < len(tried) else np.inf


def power_of(pair: _Pair, n: int, level: float, seed: int = 0) -> float:
    """Return the share of draws of n values from each sample in which the pair is separated."""
    needed = critical_distance(n, level) if not pair.tied else _tied_critical_distance(pair, n, level)
    if needed is None:
        return 0.0
    rng = np.random.default_rng((seed, n))
    these, others = (rng.multinomial(n, np.full(len(own), 1 / len(own)), DRAWS) for own in pair[:2])
    steps = np.concatenate((these, -others), axis=1)[:, pair.order].cumsum(axis=1)
    distance = np.abs(steps[:, pair.last]).max(axis=1)
    chance = np.einsum("di,ij,dj->d", these, pair.won, others, optimize=True) / n**2
    clear = np.abs(chance - 0.5) > norm.ppf(0.975) * np.sqrt(pair.spread / n)
    return float(np.mean((distance >= needed) & clear))


def _tied_critical_distance(pair: _Pair, n: int, level: float) -> float | None:
    """Return the distance, times n, from which on the test given the ties is significant.

    Above :data:`EXACT_TIES` trials, for which it is costly, it grows with the square root of n, as in the limit.
    """
    own = min(n, EXACT_TIES)
    needed = tied_critical_distance(_steps(pair, own), level)
    return None if needed is None else needed * (n / own) ** 0.5


def _steps(pair: _Pair, n: int) -> NDArray[np.bool_]:
    """Return whether the value changes after each of 2n sorted values that are tied as those of the samples are."""
    expected = np.concatenate(
        (np.full(len(pair.this), n / len(pair.this)), np.full(len(pair.other), n / len(pair.other)))
    )
    ends = np.rint(expected[pair.order].cumsum()).astype(np.int64)[pair.last]
    sizes = np.diff(np.append(-1, np.flatnonzero(pair.last)))  # of groups of equal values
    changes = np.ones(2 * n, dtype=bool)
    for start, end, size in zip(np.append(0, ends[:-1]), ends, sizes, strict=True):
        if size > 1:
            changes[start : max(end - 1, start)] = False
    return changes
