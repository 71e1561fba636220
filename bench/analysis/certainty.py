"""How sure mean ranks are: those of other trials on the same problems, with the trials of every cell drawn again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from bench.analysis.cells import cells, complete_problems, labels
from bench.analysis.direction import TWO_SIDED
from bench.analysis.pairwise import percentile_interval
from bench.analysis.standings import against_rivals, ranks, won
from bench.typing import Floats

RESAMPLES = {30: 999, 100: 199}
"""Resamples up to a number of optimizers: the cost of one grows with their square."""

AT_ONCE = 2**20  # pairs of optimizers in memory
FEWEST = 39  # resamples of more optimizers: the smallest number whose extremes are a 95 % interval

COLUMNS = ("optimizer", "problems", "rank_low", "rank_high")


def ranking_certainty(frame: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return how far as many other trials on the same problems could move the ranking, one row an optimizer.

    Columns: optimizer; problems, those on which every optimizer has a trial; rank_low to rank_high, a 95 % interval of
    the mean rank that such trials give on average. That is not the rank by the true A12: ranks of few trials lie
    nearer to each other, and no number of problems makes up for that.

    Trials are drawn with replacement within each cell (Efron 1979): 999 times, or 199 times with more than 30
    optimizers, or 39 times with more than 100. Ranks of resamples lie still nearer to each other, so the percentile
    interval alone is shifted: the interval reaches from the lower of its end and of the observed rank less 1.96
    standard deviations of the resamples to the higher of the ends on the other side. Missing where no problem has
    trials of every optimizer, or a cell of one has a single trial, which leaves nothing to draw.
    """
    by_cell, optimizers = cells(frame, merge=True), labels(frame, "optimizer")
    problems = complete_problems(frame)
    sizes = [len(by_cell[problem, one]) for problem in problems for one in optimizers]
    if not problems or min(sizes) < 2:
        return pd.DataFrame({"optimizer": optimizers, "problems": len(problems)}, columns=list(COLUMNS))
    drawn = resamples(len(optimizers))
    rng = np.random.default_rng(seed)
    total = np.zeros((len(optimizers), 1 + drawn))  # the first column is that of the values themselves
    for problem in problems:
        values = [by_cell[problem, optimizer] for optimizer in optimizers]
        total += ranks_of_draws(values, [_times_drawn(len(sample), drawn, rng) for sample in values])
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


def resamples(optimizers: int) -> int:
    """Return how often trials are drawn again, by the number of optimizers."""
    return next((drawn for most, drawn in RESAMPLES.items() if optimizers <= most), FEWEST)


def ranks_of_draws(values: Sequence[Floats], drawn: Sequence[Floats]) -> Floats:
    """Return the (k, B) ranks of k optimizers in B draws from their values, as :func:`bench.analysis.standings` ranks.

    Args:
        values: the values of each optimizer.
        drawn: how often each of these counts in each draw, (n, B) an optimizer.
    """
    owner = np.repeat(np.arange(len(values)), [len(sample) for sample in values])
    pooled, counts = np.concatenate(values), np.concatenate(drawn)
    sizes = np.array([counts_of.sum(axis=0, dtype=float) for counts_of in drawn]).T
    beaten, chance = np.zeros((2, *sizes.T.shape))
    at_once = max(AT_ONCE // len(values) ** 2, 1)
    for start in range(0, len(sizes), at_once):
        chosen = slice(start, start + at_once)
        lower = won(pooled, owner, counts[:, chosen].T)
        lower = lower / (sizes[chosen, :, np.newaxis] * sizes[chosen, np.newaxis, :])
        lower[:, np.arange(len(values)), np.arange(len(values))] = 0.5
        beaten[:, chosen], chance[:, chosen] = (sums.T for sums in against_rivals(lower, axis=1))
    return ranks(beaten, chance)


def _times_drawn(n: int, resamples: int, rng: np.random.Generator) -> Floats:
    """Return how often each of n values counts, (n, 1 + B): once, and as it is drawn in each resample."""
    drawn = rng.multinomial(n, np.full(n, 1 / n), size=resamples).T
    return np.concatenate((np.ones((n, 1)), drawn), axis=1)
