"""The order of the optimizers under other analyses that could have been chosen: a *multiverse*.

Steegen, Tuerlinckx, Gelman and Vanpaemel (2016, Perspectives on Psychological Science 11). It shows whether a
conclusion depends on the choice; the analyses share their trials, so how many of them agree is no test.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from bench.analysis.cells import Traces, labels, merge_near_ties
from bench.analysis.stages import stage_values
from bench.analysis.standings import against_rivals, ranks, won
from bench.analysis.strata import Samples, rows
from bench.typing import Floats

MULTIVERSE = (0.1, 0.3, 1.0)  # of the budget
POOLED, APART = "pooled", "by instance"
MEASURES = ("median", "mean", "probability to end lower")
TIED = 1e-12  # shares this close to 0.5 are a rounded 0.5


def multiverse(
    frame: pd.DataFrame,
    traces: Traces,
    budget: Mapping[str, int],
    leader: str,
    areas: Mapping[float, pd.DataFrame] | None = None,
    shares: Sequence[float] = MULTIVERSE,
) -> pd.DataFrame:
    """Return a row an analysis and optimizer: measure, sample, share, optimizer, rank and behind.

    An analysis is a choice of each of the first three. ``measure`` is the "median" or the "mean" of the best values
    after a ``share`` of the budget, by which of two optimizers the one is first that is lower on more problems; the
    "probability to end lower", by which the one is that has more than 1/2 in the mean over problems; or a set of
    targets, by which the one with the larger area under its runtime ECDF is. ``sample`` is "pooled" or "by instance",
    where instances are pooled: then two optimizers are compared on each instance, and the mean over instances counts.

    ``rank`` is 1 for the optimizer that is first against the most rivals; ties share their mean rank. ``behind`` is 1
    where it is behind the leader, 0 where it is before it, 0.5 where neither is. Only problems on which every optimizer
    has a trial count, and only sets of targets of which any was reached.

    Args:
        frame: the tidy frame.
        traces: of its trials.
        budget: the evaluations of a trial by problem.
        leader: the label of an optimizer.
        areas: of :func:`bench.analysis.compare_sets`, by share of the budget.
        shares: of the budget.
    """
    optimizers = labels(frame, "optimizer")
    samples = (POOLED, APART) if any(len(strata) > 1 for strata in rows(frame).values()) else (POOLED,)
    sums: dict[tuple[str, str, float], Floats] = {}
    problems = 0
    for _, _, values in stage_values(frame, traces, budget, shares):
        problems += 1
        together = [[np.concatenate(cells, axis=1) for cells in zip(*values, strict=True)]]
        for sample in samples:
            strata = together if sample == POOLED else values
            for place, share in enumerate(shares):
                at_share = [[cell[place] for cell in cells] for cells in strata]
                for measure in MEASURES:
                    lower = np.mean([_lower(cells, measure) for cells in at_share], axis=0)
                    key = measure, sample, share
                    sums[key] = sums.get(key, 0.0) + (lower if measure == MEASURES[-1] else _sign(lower))
    tables = []
    for (measure, sample, share), total in sums.items():
        chances = total / problems
        np.fill_diagonal(chances, 0.5)
        chances = np.where(np.abs(chances - 0.5) < TIED, 0.5, chances)
        rank, ahead = ranks(*against_rivals(chances, axis=1)), _sign(chances[optimizers.index(leader)])
        tables.append(_table(measure, sample, share, optimizers, rank, ahead))
    for share, table in (areas or {}).items():
        for name, own in table.groupby("set", sort=False):
            area = own.set_index("optimizer")["area"].reindex(optimizers).to_numpy(dtype=float).round(12)
            if area.max() > 0:
                ahead = 0.5 + 0.5 * np.sign(area[optimizers.index(leader)] - area)
                rank = own.set_index("optimizer")["rank"].reindex(optimizers).to_numpy(dtype=float)
                tables.append(_table(str(name), "", share, optimizers, rank, ahead))
    columns = ["measure", "sample", "share", "optimizer", "rank", "behind"]
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=columns)


def _lower(cells: Samples, measure: str) -> Floats:
    """Return (k, k): 1 where the first of two samples is lower by a measure, 1/2 where they tie; or the probability."""
    if measure == MEASURES[-1]:
        sizes = np.array([len(cell) for cell in cells])
        owner = np.repeat(np.arange(len(cells)), sizes)
        below = won(np.concatenate(cells), owner, np.ones((1, len(owner))))[0].T
        return np.asarray(below / np.outer(sizes, sizes))
    value = merge_near_ties(np.array([np.median(cell) if measure == MEASURES[0] else cell.mean() for cell in cells]))
    return np.asarray((value[:, np.newaxis] < value) + 0.5 * (value[:, np.newaxis] == value))


def _sign(chances: Floats) -> Floats:
    """Return 1 for chances above 1/2, 0 for those below and 1/2 for it."""
    return np.asarray(0.5 + 0.5 * np.sign(np.where(np.abs(chances - 0.5) < TIED, 0.0, chances - 0.5)))


def _table(
    measure: str, sample: str, share: float, optimizers: Sequence[str], rank: Floats, behind: Floats
) -> pd.DataFrame:
    analysis = {"measure": measure, "sample": sample, "share": share}
    return pd.DataFrame(analysis | {"optimizer": optimizers, "rank": rank, "behind": behind})
