"""Compare final values at the largest budget that all optimizers had, where budgets differ."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from bench.analysis.cells import Budgets, Traces, budgets, traces_of


def common_budgets(frame: pd.DataFrame, allowed: Budgets) -> dict[str, int]:
    """Return the largest budget of each problem that all optimizers with trials on it had.

    Empty where each problem has one budget, as where ``allowed`` does not depend on the optimizer.
    """
    cells = frame[["problem", "optimizer"]].astype(object).drop_duplicates()
    by_problem = budgets(cells, allowed).groupby(cells["problem"], sort=False)
    if (by_problem.nunique() == 1).all():
        return {}
    return {str(problem): int(most) for problem, most in by_problem.min().items()}


def at_budget(frame: pd.DataFrame, traces: Traces, common: Mapping[str, int]) -> pd.DataFrame:
    """Return the frame with the best value that each trial had after the budget of its problem as its value.

    Its other columns stay those of the whole trial. A trial that spent more and has no trace is left out: what it had
    then is unknown, which is no failure.
    """
    spent, values = (pd.to_numeric(frame[name], errors="coerce").to_numpy(float, copy=True) for name in ("nfev", "fun"))
    budget = frame["problem"].astype(object).map(common).to_numpy(float)
    over = (frame["status"] == "ok").to_numpy() & ~(spent <= budget)
    over &= np.isfinite(values)
    unknown = np.zeros(len(frame), dtype=bool)
    for place, trace in zip(np.flatnonzero(over), traces_of(frame[over], traces), strict=True):
        unknown[place] = not len(trace.values)
        values[place] = trace.at(budget[place])
    return frame.assign(fun=values)[~unknown]
