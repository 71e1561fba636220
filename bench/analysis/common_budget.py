"""Compare final values at the largest budget that all optimizers had, where budgets differ."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from bench.analysis.cells import Budgets, Traces, traces_of


def common_budgets(frame: pd.DataFrame, allowed: Budgets) -> dict[str, int]:
    """Return the largest budget of each problem that all optimizers with trials on it had.

    Empty where each problem has one budget, as where ``allowed`` does not depend on the optimizer.
    """
    if not isinstance(allowed, Mapping) or not any(isinstance(key, tuple) for key in allowed):
        return {}
    by_cell = {key: int(most) for key, most in allowed.items() if isinstance(key, tuple)}
    budgets_of: dict[str, list[int]] = {}
    for problem, optimizer in frame[["problem", "optimizer"]].drop_duplicates().itertuples(index=False, name=None):
        budgets_of.setdefault(str(problem), []).append(by_cell[problem, optimizer])
    if all(len({*several}) == 1 for several in budgets_of.values()):
        return {}
    return {problem: min(several) for problem, several in budgets_of.items()}


def at_budget(frame: pd.DataFrame, traces: Traces, budgets: Mapping[str, int]) -> pd.DataFrame:
    """Return the frame with the best value that each trial had after the budget of its problem as its value.

    Its other columns stay those of the whole trial. A trial that spent more and has no trace is left out: what it had
    then is unknown, which is no failure.
    """
    spent, values = (pd.to_numeric(frame[name], errors="coerce").to_numpy(float, copy=True) for name in ("nfev", "fun"))
    budget = frame["problem"].astype(object).map(budgets).to_numpy(float)
    over = (frame["status"] == "ok").to_numpy() & ~(spent <= budget)
    over &= np.isfinite(values)
    unknown = np.zeros(len(frame), dtype=bool)
    for place, trace in zip(np.flatnonzero(over), traces_of(frame[over], traces), strict=True):
        unknown[place] = not len(trace.values)
        values[place] = trace.at(budget[place])
    return frame.assign(fun=values)[~unknown]
