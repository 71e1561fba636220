"""Who leads when: the ranks of the optimizers after shares of the budget, and the budget that they left unused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import norm

from bench.analysis.cells import Budgets, Traces, budgets, complete_problems, labels, merge_near_ties, traces_of
from bench.analysis.certainty import ranks_of_draws
from bench.analysis.direction import effects, standardised
from bench.typing import Floats

SHARES = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0)  # of the budget

LEVEL = 0.005  # of all statements of a page on who led at smaller budgets

COLUMNS = ("problem", "optimizer", "share", "evaluations", "rank")


def stage_ranks(
    frame: pd.DataFrame, traces: Traces, budget: Mapping[str, int], shares: Sequence[float] = SHARES
) -> pd.DataFrame:
    """Return the rank of each cell after shares of the budget: problem, optimizer, share, evaluations and rank.

    The rank is that of :func:`bench.analysis.standings`, of the best values that the trials had found by then. A failed
    trial counts as +inf throughout, as does one without a trace. Only problems on which every optimizer has a trial
    have rows. ``budget`` is the number of evaluations by problem; a trial that ended early keeps its last value.
    """
    optimizers, tables = labels(frame, "optimizer"), []
    for problem, spent, values in _stages(frame, traces, budget, shares):
        once = [np.ones((len(cell), 1)) for cell in values]
        for place, share in enumerate(shares):
            rank = ranks_of_draws([cell[:, place] for cell in values], once)[:, 0]
            table = {"problem": problem, "optimizer": optimizers, "share": share, "evaluations": spent[place]}
            tables.append(pd.DataFrame(table | {"rank": rank}))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(COLUMNS))


def earlier_leads(
    frame: pd.DataFrame,
    traces: Traces,
    budget: Mapping[str, int],
    leader: str,
    level: float = LEVEL,
    shares: Sequence[float] = SHARES,
) -> pd.DataFrame:
    """Return who is lower than the leader after smaller shares of the budget: share, optimizer, probability, p, shown.

    One row a share below 1 and rival. ``probability`` is that of a run of the rival to end lower, the mean of A12 over
    the problems of :func:`stage_ranks`; ``p`` is of the hypothesis that it is 0.5 on these problems, with the variance
    that A12 = 0.5 on each would have (:mod:`bench.analysis.direction`), never below the chance of complete separation
    on all. ``shown`` is whether it is above 0.5 and p, times the number of rows (Bonferroni), is at most ``level``.
    """
    smaller = [share for share in shares if share < 1]
    optimizers = labels(frame, "optimizer")
    rivals = [place for place, label in enumerate(optimizers) if label != leader]
    stages = [
        [np.ascontiguousarray(cell.T) for cell in values] for *_, values in _stages(frame, traces, budget, smaller)
    ]
    if not stages or not rivals or not smaller:
        return pd.DataFrame(columns=["share", "optimizer", "probability", "p", "shown"])
    first = optimizers.index(leader)
    found = [[effects(values[rival], values[first]) for rival in rivals] for values in stages]
    chance, ratio = (np.array([[getattr(pair, name) for pair in row] for row in found]) for name in ("a12", "ratio"))
    smallest = np.array([[float(np.max(pair.smaller)) for pair in row] for row in found]).sum(axis=0)[:, np.newaxis]
    size = np.abs(standardised(chance, ratio))  # missing where a cell has a single trial
    p = np.where(np.isfinite(size), np.maximum(2 * norm.sf(size), np.minimum(2.0 ** (1 - smallest), 1.0)), 1.0)
    mean = chance.mean(axis=0)
    return pd.DataFrame(
        {
            "share": np.tile(smaller, len(rivals)),
            "optimizer": np.repeat([optimizers[rival] for rival in rivals], len(smaller)),
            "probability": mean.ravel(),
            "p": p.ravel(),
            "shown": ((mean > 0.5) & (p * p.size <= level)).ravel(),
        }
    )


def _stages(
    frame: pd.DataFrame, traces: Traces, budget: Mapping[str, int], shares: Sequence[float]
) -> Iterator[tuple[str, NDArray[np.int64], list[Floats]]]:
    """Yield each problem on which all have trials, the evaluations of the stages, and each cell's (trials, stages)."""
    optimizers = labels(frame, "optimizer")
    for problem in complete_problems(frame):
        trials = frame[frame["problem"] == problem]
        spent = np.maximum(np.round(np.array(shares) * budget[problem]), 1).astype(np.int64)
        values = np.array([trace.at(spent) for trace in traces_of(trials, traces)])
        merged = np.column_stack([merge_near_ties(of_stage) for of_stage in values.T])
        yield problem, spent, [merged[(trials["optimizer"] == optimizer).to_numpy()] for optimizer in optimizers]


def unused_budget(frame: pd.DataFrame, budget: Budgets) -> pd.DataFrame:
    """Return the share of the budget that the finished trials of each optimizer left: optimizer, trials, unused, early.

    ``unused`` is the mean over trials, missing without any; ``early`` is the share of trials that left more than 1%.
    """
    left = 1 - pd.to_numeric(frame["nfev"], errors="coerce").astype(float) / budgets(frame, budget)
    left = left.where(frame["status"] == "ok").clip(lower=0.0)
    rows = []
    for optimizer in labels(frame, "optimizer"):
        left_of = left[frame["optimizer"] == optimizer].dropna()
        rows.append((optimizer, len(left_of), left_of.mean(), (left_of > 0.01).mean()))
    return pd.DataFrame(rows, columns=["optimizer", "trials", "unused", "early"])
