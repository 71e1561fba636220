"""Rank the optimizers after shares of the budget, and measure the budget that they left unused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import norm

from bench.analysis.cells import Budgets, Traces, budgets, complete_problems, labels, merge_near_ties, traces_of
from bench.analysis.comparison import chance_within
from bench.analysis.direction import effects, least_p, stacked, standardised, stratified
from bench.analysis.standings import ranks
from bench.analysis.strata import Samples, rows
from bench.objective import ON_TARGET

SHARES = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0)  # of the budget

LEVEL = 0.005  # of all statements of a page on who led at smaller budgets

COLUMNS = ("problem", "optimizer", "share", "evaluations", "rank")


def stage_ranks(
    frame: pd.DataFrame, traces: Traces, budget: Mapping[str, int], shares: Sequence[float] = SHARES
) -> pd.DataFrame:
    """Return the rank of each cell after shares of the budget: problem, optimizer, share, evaluations and rank.

    The rank is that of :func:`bench.analysis.standings`, of the best values that the trials had found by then, of
    pooled instances by instance. A failed
    trial counts as +inf throughout, as does one without a trace. Only problems on which every optimizer has a trial
    have rows. ``budget`` is the number of evaluations by problem; a trial that ended early keeps its last value.
    """
    optimizers, tables = labels(frame, "optimizer"), []
    for problem, spent, values in stage_values(frame, traces, budget, shares):
        for place, share in enumerate(shares):
            at_stage = [[cell[place] for cell in own] for own in values]
            rank = ranks(chance_within(at_stage))
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
    """Return optimizers below the leader at smaller shares of the budget: share, optimizer, probability, p, shown.

    One row a share below 1 and rival. ``probability`` is that of a run of the rival to end lower, the mean of A12 over
    the problems of :func:`stage_ranks` and the strata of each (:mod:`bench.analysis.strata`); ``p`` is of the
    hypothesis that it is 0.5 on these problems, with the variance that A12 = 0.5 on each would have
    (:mod:`bench.analysis.direction`), never below the chance of complete separation on all. ``shown`` is whether it is
    above 0.5 and p, times the number of rows (Bonferroni), is at most ``level``.
    """
    smaller = [share for share in shares if share < 1]
    optimizers = labels(frame, "optimizer")
    rivals = [place for place, label in enumerate(optimizers) if label != leader]
    stages = [values for *_, values in stage_values(frame, traces, budget, smaller)] if smaller else []
    if not stages or not rivals:
        return pd.DataFrame(columns=["share", "optimizer", "probability", "p", "shown"])
    first = optimizers.index(leader)
    found = [[stratified([effects(own[rival], own[first]) for own in values]) for rival in rivals] for values in stages]
    estimates = stacked([stacked(of_problem) for of_problem in found])
    size = np.abs(standardised(estimates.a12, estimates.ratio))  # missing where a cell has a single trial
    least = least_p(np.sum(estimates.smaller, axis=0))
    p = np.where(np.isfinite(size), np.maximum(2 * norm.sf(size), least), 1.0)
    mean = estimates.a12.mean(axis=0)
    return pd.DataFrame(
        {
            "share": np.tile(smaller, len(rivals)),
            "optimizer": np.repeat([optimizers[rival] for rival in rivals], len(smaller)),
            "probability": mean.ravel(),
            "p": p.ravel(),
            "shown": ((mean > 0.5) & (p * p.size <= level)).ravel(),
        }
    )


def stage_values(
    frame: pd.DataFrame, traces: Traces, budget: Mapping[str, int], shares: Sequence[float]
) -> Iterator[tuple[str, NDArray[np.int64], list[Samples]]]:
    """Yield each problem on which all have trials, the evaluations of the stages, and the values by stratum.

    Those of each optimizer are (stages, trials).
    """
    places = rows(frame)
    for problem in complete_problems(frame):
        cells = [cell for own in places[problem] for cell in own]
        spent = np.maximum(np.round(np.array(shares) * budget[problem]), 1).astype(np.int64)
        values = np.array([trace.at(spent) for trace in traces_of(frame.iloc[np.concatenate(cells)], traces)]).T
        merged = np.array([merge_near_ties(of_stage) for of_stage in values])
        apart = np.split(merged, np.cumsum([len(cell) for cell in cells])[:-1], axis=1)
        number = len(cells) // len(places[problem])  # of optimizers
        yield problem, spent, [apart[start : start + number] for start in range(0, len(apart), number)]


def unused_budget(frame: pd.DataFrame, budget: Budgets) -> pd.DataFrame:
    """Return the share of the budget that the finished trials of each optimizer left: optimizer, trials, unused, early.

    ``unused`` is the mean over trials, missing without any; ``early`` is the share of trials that left more than 1%. A
    trial that ended as its value was good enough left nothing.
    """
    left = 1 - pd.to_numeric(frame["nfev"], errors="coerce").astype(float) / budgets(frame, budget)
    left = left.where(frame["status"] == "ok").clip(lower=0.0).mask(frame["stop"] == ON_TARGET, 0.0)
    rows = []
    for optimizer in labels(frame, "optimizer"):
        left_of = left[frame["optimizer"] == optimizer].dropna()
        rows.append((optimizer, len(left_of), left_of.mean(), (left_of > 0.01).mean()))
    return pd.DataFrame(rows, columns=["optimizer", "trials", "unused", "early"])
