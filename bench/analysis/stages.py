"""Who leads when: the ranks of the optimizers after shares of the budget, and the budget that they left unused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from bench.analysis.cells import Budgets, Traces, budgets, labels, merge_near_ties, scores
from bench.analysis.standings import against_rivals, ranks, won

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
    final, optimizers = scores(frame), labels(frame, "optimizer")
    keys = [frame[name].astype(object).to_numpy() for name in ("problem", "optimizer", "trial")]
    values = np.full((len(frame), len(shares)), np.inf)
    for row, (problem, optimizer, trial, end) in enumerate(zip(*keys, final, strict=True)):
        trace = traces.get((problem, optimizer, trial)) if np.isfinite(end) else None
        if trace is not None and len(trace.values):
            values[row] = trace.at(_spent(budget[problem], shares))
    tables = []
    rows_of = frame.groupby([keys[0], keys[1]], sort=False).indices
    for problem in labels(frame, "problem"):
        cells = [rows_of.get((problem, optimizer), np.empty(0, dtype=np.intp)) for optimizer in optimizers]
        if not cells or not all(map(len, cells)):
            continue
        sizes = np.array(list(map(len, cells)))
        owner, once = np.repeat(np.arange(len(cells)), sizes), np.ones((1, sizes.sum()))
        spent = _spent(budget[problem], shares)
        for place, share in enumerate(shares):
            merged = merge_near_ties(values[np.concatenate(cells), place])
            chances = won(merged, owner, once)[0] / np.multiply.outer(sizes, sizes)
            rank = ranks(*against_rivals(chances, axis=0))
            rows = {"problem": problem, "optimizer": optimizers, "share": share, "evaluations": spent[place]}
            tables.append(pd.DataFrame(rows | {"rank": rank}))
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(COLUMNS))


def unused_budget(frame: pd.DataFrame, budget: Budgets) -> pd.DataFrame:
    """Return the share of the budget that the finished trials of each optimizer left: optimizer, trials, unused, early.

    ``unused`` is the mean over trials, missing without any; ``early`` is the share of trials that left more than 1 %.
    """
    left = 1 - pd.to_numeric(frame["nfev"], errors="coerce").astype(float) / budgets(frame, budget)
    left = left.where(frame["status"] == "ok").clip(lower=0.0)
    rows = []
    for optimizer in labels(frame, "optimizer"):
        left_of = left[frame["optimizer"] == optimizer].dropna()
        rows.append((optimizer, len(left_of), left_of.mean(), (left_of > 0.01).mean()))
    return pd.DataFrame(rows, columns=["optimizer", "trials", "unused", "early"])


def _spent(budget: int, shares: Sequence[float]) -> np.ndarray:
    return np.maximum(np.round(np.array(shares) * budget), 1).astype(np.int64)
