"""How sure a ranking is: first places and mean ranks when the trials of every cell are drawn again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from bench.analysis.cells import cells, complete_problems, labels
from bench.analysis.pairwise import percentile_interval
from bench.analysis.standings import against_rivals, ranks, won
from bench.problem import Floats

RESAMPLES = {30: 999, 100: 199}
"""Resamples up to a number of optimizers: the cost of one grows with their square."""

AT_ONCE = 2**20  # pairs of optimizers in memory
FEWEST = 39  # resamples of more optimizers: the smallest number whose extremes are a 95 % interval

COLUMNS = ("optimizer", "problems", "first_low", "first_high", "rank_low", "rank_high", "leads")


def ranking_certainty(frame: pd.DataFrame, seed: int = 0) -> pd.DataFrame:
    """Return how far other trials on the same problems could move the ranking, one row an optimizer.

    Columns: optimizer; problems, those on which every optimizer has a trial; first_low to first_high, the 95 %
    percentile interval of the number of problems on which the optimizer is ranked first (:func:`bench.analysis.ranking`
    without its tests, which resampled values would mislead by their ties); rank_low to rank_high, that of its mean
    rank, both widened to the observed value where resamples, which break ties and know fewer values, shift all of them
    to one side; leads, the share of resamples in which its mean rank is the lowest, a tie shared.

    Trials are drawn with replacement within each cell (Efron 1979): 999 times, or 199 times with more than 30
    optimizers, or 39 times with more than 100. All is missing where no problem has trials of every optimizer, or a cell
    of one has a single trial, which leaves nothing to draw.
    """
    found, optimizers = cells(frame, merge=True), labels(frame, "optimizer")
    problems = complete_problems(frame)
    sizes = [len(found[each, one]) for each in problems for one in optimizers]
    if not problems or min(sizes) < 2:
        return pd.DataFrame({"optimizer": optimizers, "problems": len(problems)}, columns=list(COLUMNS))
    resamples = next((drawn for most, drawn in RESAMPLES.items() if len(optimizers) <= most), FEWEST)
    rng = np.random.default_rng(seed)
    first, total = np.zeros((2, len(optimizers), 1 + resamples))  # the first column is that of the values themselves
    for problem in problems:
        values = [found[problem, each] for each in optimizers]
        own = ranks_of_draws(values, [_times_drawn(len(each), resamples, rng) for each in values])
        first += own == own.min(axis=0)
        total += own
    mean = total / len(problems)
    lowest = np.isclose(mean, mean.min(axis=0), rtol=0, atol=1e-9)[:, 1:]
    leads = (lowest / lowest.sum(axis=0)).mean(axis=1)
    rows = []
    for place, optimizer in enumerate(optimizers):
        counts = _widened(_whole(first[place, 1:]), int(first[place, 0]))
        interval = _widened(percentile_interval(mean[place, 1:]), float(mean[place, 0]))
        rows.append((optimizer, len(problems), *counts, *interval, leads[place]))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _widened(interval: tuple[float, float], observed: float) -> tuple[float, float]:
    return min(interval[0], observed), max(interval[1], observed)


def _whole(counts: Floats) -> tuple[int, int]:
    """Return the ends of the interval of a count, which are counts themselves."""
    low, high = np.quantile(counts, [0.025, 0.975], method="inverted_cdf")
    return int(low), int(high)


def ranks_of_draws(values: Sequence[Floats], drawn: Sequence[Floats]) -> Floats:
    """Return the (k, B) ranks of k optimizers in B draws from their values, as :func:`bench.analysis.standings` ranks.

    Args:
        values: the values of each optimizer.
        drawn: how often each of these counts in each draw, (n, B) an optimizer.
    """
    owner = np.repeat(np.arange(len(values)), [len(each) for each in values])
    pooled, counts = np.concatenate(values), np.concatenate(drawn)
    sizes = np.array([each.sum(axis=0, dtype=float) for each in drawn]).T
    beaten, chance = np.zeros((2, *sizes.T.shape))
    at_once = max(AT_ONCE // len(values) ** 2, 1)
    for start in range(0, len(sizes), at_once):
        chosen = slice(start, start + at_once)
        lower = won(pooled, owner, counts[:, chosen].T)
        lower = lower / (sizes[chosen, :, np.newaxis] * sizes[chosen, np.newaxis, :])
        lower[:, np.arange(len(values)), np.arange(len(values))] = 0.5
        beaten[:, chosen], chance[:, chosen] = (each.T for each in against_rivals(lower, axis=1))
    return ranks(beaten, chance)


def _times_drawn(n: int, resamples: int, rng: np.random.Generator) -> Floats:
    """Return how often each of n values counts, (n, 1 + B): once, and as it is drawn in each resample."""
    drawn = rng.multinomial(n, np.full(n, 1 / n), size=resamples).T
    return np.concatenate((np.ones((n, 1)), drawn), axis=1)
