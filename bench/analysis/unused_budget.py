"""The budget that finished trials left unused."""

from __future__ import annotations

import pandas as pd

from bench.analysis.cells import Budgets, budgets, labels
from bench.contract.objective import ON_TARGET


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
