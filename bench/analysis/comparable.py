"""Choose which trials of a study are compared: on the same instances, at one budget, with an objective that works."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from bench.analysis.cells import Budgets, Traces, budgets, traces_of
from bench.helpers.errors import PROBLEM_FAILED

NEARLY = 1.01  # times the common budget that a trial without a trace may have spent, as generations overshoot


class Comparable(NamedTuple):
    """The trials that are compared, and what is left out.

    Attributes:
        frame: the trials whose values are compared, each with its best value at the common budget.
        working: all trials, with their final values, but those on problems that failed.
        common: the largest budget of each problem that all optimizers had; empty where budgets do not differ.
        failed: the problems, or instances, whose own code raised: in how many trials, and of how many.
        instances: how many instances of a problem all optimizers share, and of how many, where some differ.
        unknown: the cells, (problem, optimizer), of which some values at the common budget are unknown: how many.
    """

    frame: pd.DataFrame
    working: pd.DataFrame
    common: dict[str, int]
    failed: dict[str, tuple[int, int]]
    instances: dict[str, tuple[int, int]]
    unknown: dict[tuple[str, str], int]


def comparable(frame: pd.DataFrame, traces: Traces, allowed: Budgets, late: Collection[str] = ()) -> Comparable:
    """Return the part of a tidy frame, and of its traces, that is compared.

    A problem whose own code raised in any trial is left out, as the failure says nothing about an optimizer. Of a
    problem with pooled instances, those count that all optimizers with trials on it share. Where budgets differ, values
    are those at the largest budget that all had, and a cell with a value that is unknown there is left out whole: those
    of its trials that ended before are no fair sample of it.

    Args:
        frame: the tidy frame; pooled problems have the column ``instance`` (:mod:`bench.analysis.instances`).
        traces: of its trials.
        allowed: the evaluations that each trial was allowed.
        late: the optimizers whose traces may begin late, as those of results made elsewhere do that note final values
            alone: what was found before is unknown. Other trials had no finite value before their trace begins.
    """
    working, failed = _with_working_objective(frame)
    shared, instances = _on_shared_instances(working)
    common = common_budgets(shared, allowed)
    compared, unknown = _at_budget(shared, traces, common, late) if common else (shared, {})
    return Comparable(compared, working, common, failed, instances, unknown)


def common_budgets(frame: pd.DataFrame, allowed: Budgets) -> dict[str, int]:
    """Return the largest budget of each problem that all optimizers with trials on it had.

    Empty where each problem has one budget, as where ``allowed`` does not depend on the optimizer; up to 1% more counts
    as the same.
    """
    cells = frame[["problem", "optimizer"]].astype(object).drop_duplicates()
    by_problem = budgets(cells, allowed).groupby(cells["problem"], sort=False)
    if (by_problem.max() <= NEARLY * by_problem.min()).all():
        return {}
    return {str(problem): int(most) for problem, most in by_problem.min().items()}


def blames_problem(frame: pd.DataFrame) -> pd.Series[bool]:
    """Return a flag for each trial: True where its ``error`` says that the problem's own code raised."""
    if "error" not in frame:
        return pd.Series(False, index=frame.index)
    lost = frame["status"] != "ok"
    return lost & frame["error"].astype(object).fillna("").astype(str).str.startswith(PROBLEM_FAILED)


def _with_working_objective(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, tuple[int, int]]]:
    """Return the trials on problems, or instances, whose own code raised in none, and how often the others' raised."""
    raised = blames_problem(frame)
    if not raised.any():
        return frame, {}
    label = frame["problem"].astype(object)
    if "instance" in frame:
        pooled = frame["instance"].notna()
        ending = pd.Series([f"-i{instance}" for instance in frame["instance"]], frame.index, dtype=object)
        pooled &= np.array([not name.endswith(end) for name, end in zip(label, ending, strict=True)], dtype=bool)
        label = label.where(~pooled, label + ending)
    counts = raised.groupby(label, sort=False).agg(["sum", "size"])
    failed = {str(name): (int(row["sum"]), int(row["size"])) for name, row in counts.iterrows() if row["sum"]}
    return frame[~label.isin(failed)], failed


def _on_shared_instances(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, tuple[int, int]]]:
    """Return the trials on instances that all optimizers share, and the numbers of these where some do not."""
    differ: dict[str, tuple[int, int]] = {}
    if "instance" not in frame:
        return frame, differ
    kept = np.ones(len(frame), dtype=bool)
    problem, instance = frame["problem"].astype(object), frame["instance"].astype(object)
    rows = pd.DataFrame({"problem": problem, "optimizer": frame["optimizer"].astype(object), "instance": instance})
    cells = rows.dropna().drop_duplicates().groupby(["problem", "optimizer"], sort=False)["instance"].agg(frozenset)
    for label, sets in cells.groupby(level=0, sort=False):
        shared, every = frozenset.intersection(*sets), frozenset.union(*sets)
        if shared != every:
            differ[str(label)] = len(shared), len(every)
            kept &= ~((problem == label) & ~instance.isin(shared)).to_numpy()
    return (frame[kept] if differ else frame), differ


def _at_budget(
    frame: pd.DataFrame, traces: Traces, common: Mapping[str, int], late: Collection[str]
) -> tuple[pd.DataFrame, dict[tuple[str, str], int]]:
    """Return the trials with the best value that each had at the budget of its problem, and the unknown ones by cell.

    Other columns stay those of the whole trial. What a trial had then is unknown where it spent more and has no trace;
    up to 1%
    more counts as the same budget.
    """
    spent, values = (pd.to_numeric(frame[name], errors="coerce").to_numpy(float, copy=True) for name in ("nfev", "fun"))
    budget = frame["problem"].astype(object).map(common).to_numpy(float)
    over = (frame["status"] == "ok").to_numpy() & ~(spent <= budget)
    over &= np.isfinite(values)
    unknown, begins_late = np.zeros(len(frame), dtype=bool), frame["optimizer"].isin(late).to_numpy()
    for place, trace in zip(np.flatnonzero(over), traces_of(frame[over], traces), strict=True):
        if len(trace.values) and not (begins_late[place] and trace.evaluations[0] > budget[place]):
            values[place] = trace.at(budget[place])
        else:
            unknown[place] = not spent[place] <= NEARLY * budget[place]
    cells = pd.Series([*zip(frame["problem"], frame["optimizer"], strict=True)], index=frame.index, dtype=object)
    left_out = dict(Counter(cells[unknown]))
    return frame.assign(fun=values)[~cells.isin(left_out)], left_out
