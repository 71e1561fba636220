"""State who reaches the targets first in seconds, and at which cost of an evaluation this changes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from bench.analysis.compare import table as table_of
from bench.report.prose import speaker
from bench.topics.findings import Findings

UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))


class Clock(NamedTuple):
    """The fastest optimizer in seconds, the cost of an evaluation below which it is, and a sentence on both."""

    fastest: str
    cost: str
    sentence: str


def clock(findings: Findings) -> Clock | None:
    """Return the optimizer that reaches the targets first in seconds; None if it is also the first in evaluations."""
    chosen, table = findings.anytime.target_set, findings.anytime.running_times
    if table.empty:
        return None
    solved = table.loc[table["successes"] > 0, chosen.unit].unique().tolist()
    level = chosen.level if chosen.level in solved else min(solved, default=np.nan)
    times = table[table[chosen.unit] == level]
    if times.empty:
        return None
    ert, seconds = (table_of(times, name).astype(float).replace(np.inf, np.nan) for name in ("ert", "ert_s"))
    first, fast = (times_in.eq(times_in.min(axis=1), axis=0).sum() for times_in in (ert, seconds))
    leader, fastest = str(first.idxmax()), str(fast.idxmax())
    problems = times["problem"].nunique()
    if leader == fastest or 2 * min(first[leader], fast[fastest]) <= problems:
        return None  # an order is turned round only where there is one, on most problems
    costs = break_even(ert, overhead(findings.trials.whole), leader, fastest).dropna()
    if costs.empty:
        return None
    return Clock(
        fastest,
        _cost(float(costs.median())),
        speaker(__package__)(
            "clock", fastest, leader, _spread(costs), chosen.at_length(level), first[leader], fast[fastest], problems
        ),
    )


def overhead(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the optimizers' own seconds for each evaluation, the median of each cell, problems by optimizers."""
    wall, objective, nfev = (
        pd.to_numeric(frame[name], errors="coerce").astype(float) for name in ("wall_s", "objective_s", "nfev")
    )
    cost = ((wall - objective) / nfev.where(nfev > 0)).where(frame["status"] == "ok")
    keys = [frame["problem"].astype(object), frame["optimizer"].astype(object)]
    return cost.groupby(keys).median().unstack()


def break_even(ert: pd.DataFrame, overheads: pd.DataFrame, leader: str, fastest: str) -> pd.Series[float]:
    """Return the seconds of one evaluation at which two optimizers reach a target in the same time, by problem.

    Up to this cost the optimizer with more evaluations and less overhead is the faster one. The time is ERT times
    the overhead and the cost of an evaluation. Missing where one optimizer is faster at any cost.

    Args:
        ert: the ERT in evaluations, problems by optimizers.
        overheads: the optimizers' own seconds for each evaluation, likewise.
        leader: the optimizer with fewer evaluations.
        fastest: the other one.
    """
    seconds = ert * overheads.reindex(index=ert.index, columns=ert.columns)
    cost = (seconds[leader] - seconds[fastest]) / (ert[fastest] - ert[leader]).where(lambda more: more > 0)
    return cost.where(cost > 0)


def _cost(seconds: float) -> str:
    """Return seconds as "1.8 us"."""
    factor, unit = next(((size, name) for size, name in UNITS if seconds >= size), UNITS[-1])
    return f"{float(f'{seconds / factor:.2g}'):g} {unit}"


def _spread(costs: pd.Series[float]) -> str:
    """Return seconds as "1.8 us (median of 18 problems; 0.25 to 19 us)"."""
    middle = float(costs.median())
    factor, unit = next(((size, name) for size, name in UNITS if middle >= size), UNITS[-1])
    low, high = (f"{float(f'{value / factor:.2g}'):g}" for value in (costs.min(), costs.max()))
    several = f" (median of {len(costs)} problems; {low} to {high} {unit})" if len(costs) > 1 else ""
    return f"{_cost(middle)}{several}"
