"""How sure mean ranks are: those of other trials on the same problems, and those that fewer trials would have given.

A ranking that still moves with the last trials needs more of them. The ranks of random subsets of the trials show how
much of a move is chance (subsampling, Politis and Romano 1994, The Annals of Statistics 22). All subsets agree once
they hold all trials; what other trials would give is shown by all of them drawn again.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.analysis.cells import complete_problems, labels
from bench.analysis.direction import TWO_SIDED
from bench.analysis.pairwise import percentile_interval
from bench.analysis.standings import against_rivals, ranks, won
from bench.analysis.strata import Samples, strata
from bench.typing import Floats

RESAMPLES = {30: 999, 100: 199}
"""Resamples up to a number of optimizers: the cost of one grows with their square."""

AT_ONCE = 2**20  # pairs of optimizers in memory
FEWEST = 39  # resamples of more optimizers: the smallest number whose extremes are a 95% interval

FIRST = 3  # trials
STEPS = {30: (12, 39), 100: (8, 19)}
"""Numbers of trials, and random subsets of each, up to a number of optimizers; the extremes of 39 are 95% limits."""
FEWEST_SUBSETS = (4, 9)  # of more optimizers, as the cost grows with their square

COLUMNS = ("optimizer", "problems", "rank_low", "rank_high")
STABILITY = ("optimizer", "trials", "rank", "low", "high")


def ranking_certainty(frame: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return how far as many other trials on the same problems could move the ranking, one row an optimizer.

    Columns: optimizer; problems, those on which every optimizer has a trial; rank_low to rank_high, a 95% interval of
    the mean rank that such trials give on average. That is not the rank by the true A12: ranks of few trials lie
    nearer to each other, and no number of problems makes up for that.

    Trials are drawn with replacement within each cell (Efron 1979): 999 times, or 199 times with more than 30
    optimizers, or 39 times with more than 100. Ranks of resamples lie still nearer to each other, so the percentile
    interval alone is shifted: the interval reaches from the lower of its end and of the observed rank less 1.96
    standard deviations of the resamples to the higher of the ends on the other side. Missing where no problem has
    trials of every optimizer, or a cell of one has a single trial, which leaves nothing to draw.
    """
    by_problem, optimizers = strata(frame), labels(frame, "optimizer")
    problems = complete_problems(frame)
    sizes = [len(sample) for problem in problems for samples in by_problem[problem] for sample in samples]
    if not problems or min(sizes) < 2:
        return pd.DataFrame({"optimizer": optimizers, "problems": len(problems)}, columns=list(COLUMNS))
    drawn = resamples(len(optimizers))
    rng = np.random.default_rng(seed)
    total = np.zeros((len(optimizers), 1 + drawn))  # the first column is that of the values themselves
    for problem in problems:
        total += ranks_of_strata(
            [(own, [_times_drawn(len(sample), drawn, rng) for sample in own]) for own in by_problem[problem]]
        )
    mean = total / len(problems)
    reach = TWO_SIDED * mean[:, 1:].std(axis=1, ddof=1) * (min(sizes) / (min(sizes) - 1)) ** 0.5
    low, high = np.array([percentile_interval(draws[1:]) for draws in mean]).T
    return pd.DataFrame(
        {
            "optimizer": optimizers,
            "problems": len(problems),
            "rank_low": np.maximum(np.minimum(low, mean[:, 0] - reach), 1.0),
            "rank_high": np.minimum(np.maximum(high, mean[:, 0] + reach), float(len(optimizers))),
        }
    )


def rank_stability(frame: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return the mean rank of each optimizer with its first 3, …, all trials: optimizer, trials, rank, low and high.

    ``rank`` is that of :func:`bench.analysis.standings`, the mean over the problems on which every optimizer has a
    trial; ``low`` to ``high`` is the range of it over 39 random subsets of as many trials (19 with more than 30
    optimizers, 9 with more than 100). A cell with fewer trials enters with all it has. The first trials of pooled
    instances are the first of each instance in turn. Empty with fewer than four trials in the largest cell.
    """
    by_problem, optimizers = strata(_in_turn(frame)), labels(frame, "optimizer")
    problems = complete_problems(frame)
    most = max(
        (sum(map(len, samples)) for problem in problems for samples in zip(*by_problem[problem], strict=True)),
        default=0,
    )
    if most <= FIRST or len(optimizers) < 2:
        return pd.DataFrame(columns=list(STABILITY))
    steps, subsets = next((number for limit, number in STEPS.items() if len(optimizers) <= limit), FEWEST_SUBSETS)
    sizes = np.unique(np.geomspace(FIRST, most, steps).round().astype(int))
    rng = np.random.default_rng(seed)
    total = np.zeros((len(optimizers), len(sizes) * (1 + subsets)))
    for problem in problems:
        every = by_problem[problem]
        shares = np.maximum(np.round(sizes / len(every)), 1)
        total += ranks_of_strata(
            [(own, [_subsets(len(sample), shares, subsets, rng) for sample in own]) for own in every]
        )
    means = (total / len(problems)).reshape(len(optimizers), len(sizes), 1 + subsets)
    rows = {
        "optimizer": np.repeat(np.array(optimizers, dtype=object), len(sizes)),
        "trials": np.tile(sizes, len(optimizers)),
        "rank": means[:, :, 0].ravel(),
        "low": means.min(axis=2).ravel(),
        "high": means.max(axis=2).ravel(),
    }
    return pd.DataFrame(rows)[list(STABILITY)]


def resamples(optimizers: int) -> int:
    """Return how often trials are drawn again, by the number of optimizers."""
    return next((drawn for most, drawn in RESAMPLES.items() if optimizers <= most), FEWEST)


def ranks_of_strata(by_stratum: Sequence[tuple[Samples, Sequence[Floats]]]) -> Floats:
    """Return the (k, B) ranks of k optimizers in B draws from their values, as :func:`bench.analysis.standings` ranks.

    ``by_stratum`` has the values of each optimizer in each stratum, and how often each of these counts in each draw,
    (n, B) an optimizer.
    """
    optimizers, draws = len(by_stratum[0][0]), by_stratum[0][1][0].shape[1]
    beaten, chance = np.zeros((2, optimizers, draws))
    at_once = max(AT_ONCE // optimizers**2, 1)
    for start in range(0, draws, at_once):
        chosen = slice(start, start + at_once)
        every = [_lower(values, [counts[:, chosen] for counts in drawn]) for values, drawn in by_stratum]
        lower = np.sum(every, axis=0) / len(every)
        lower[:, np.arange(optimizers), np.arange(optimizers)] = 0.5
        beaten[:, chosen], chance[:, chosen] = (sums.T for sums in against_rivals(lower, axis=1))
    return ranks(beaten, chance)


def _lower(values: Samples, drawn: Sequence[Floats]) -> Floats:
    """Return the share of pairs of drawn values of which that of the second optimizer is lower, (B, k, k)."""
    owner = np.repeat(np.arange(len(values)), [len(sample) for sample in values])
    sizes = np.array([counts.sum(axis=0, dtype=float) for counts in drawn]).T
    lower = won(np.concatenate(values), owner, np.concatenate(drawn).T)
    return np.asarray(lower / (sizes[:, :, np.newaxis] * sizes[:, np.newaxis, :]))


def _times_drawn(n: int, resamples: int, rng: np.random.Generator) -> Floats:
    """Return how often each of n values counts, (n, 1 + B): once, and as it is drawn in each resample."""
    drawn = rng.multinomial(n, np.full(n, 1 / n), size=resamples).T
    return np.concatenate((np.ones((n, 1)), drawn), axis=1)


def _in_turn(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the trials in the order of their numbers within an instance, where instances are pooled."""
    if "instance" not in frame:
        return frame
    turn = frame.groupby(["problem", "optimizer", "instance"], observed=True, dropna=False).cumcount()
    return frame.iloc[np.argsort(turn.to_numpy(), kind="stable")]


def _subsets(n: int, sizes: NDArray[np.int_], subsets: int, rng: np.random.Generator) -> Floats:
    """Return flags of subsets of n values, (n, sizes x (1 + subsets)): for each size the first, then random ones."""
    place = np.arange(n)
    orders = np.stack([place, *(rng.permutation(n) for _ in range(subsets))], axis=1)
    counted = orders[:, np.newaxis, :] < sizes[np.newaxis, :, np.newaxis]
    return np.asarray(counted.reshape(n, -1), dtype=np.float64)
