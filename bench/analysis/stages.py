"""Who leads when: the ranks of the optimizers after shares of the budget, and the budget that they left unused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from bench.analysis.cells import Budgets, Traces, budgets, complete_problems, labels, merge_near_ties, traces_of
from bench.analysis.certainty import ranks_of_draws

SHARES = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0)  # of the budget

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
    for problem in complete_problems(frame):
        trials = frame[frame["problem"] == problem]
        spent = np.maximum(np.round(np.array(shares) * budget[problem]), 1).astype(np.int64)
        values = np.array([trace.at(spent) for trace in traces_of(trials, traces)])
        cells = [np.flatnonzero(trials["optimizer"] == optimizer) for optimizer in optimizers]
        once = [np.ones((len(rows), 1)) for rows in cells]
        for place, share in enumerate(shares):
            merged = merge_near_ties(values[:, place])
            rank = ranks_of_draws([merged[rows] for rows in cells], once)[:, 0]
            table = {"problem": problem, "optimizer": optimizers, "share": share, "evaluations": spent[place]}
            tables.append(pd.DataFrame(table | {"rank": rank}))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(COLUMNS))


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
