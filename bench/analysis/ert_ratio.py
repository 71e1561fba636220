"""How many times as many evaluations rivals need as a chosen optimizer, over all problems, with an interval."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from bench.typing import Flags, Floats

RESAMPLES = 1000
SEED = 1
COLUMNS = ("rival", "problems", "bounded", "ratio", "low", "high")


def ert_ratios(hits: pd.DataFrame, chosen: str, rivals: Sequence[str]) -> pd.DataFrame:
    """Return the geometric mean over problems of a rival's expected running time over that of the chosen optimizer.

    Columns: rival; problems, those that either of the two reaches; bounded, those that only one does: the other enters
    by a bound, all evaluations that its runs spent, as if the last one had just reached it; ratio; and low to high,
    its 95% interval. That is the bootstrap's of runs within cells, on the scale of logarithms and widened by
    sqrt(n / (n - 1)), as runs that are drawn again spread too little; missing where a cell has a single run.

    Args:
        hits: hitting times of one target a problem (:func:`bench.analysis.hitting_times`).
        chosen: the optimizer whose time divides the others'.
        rivals: the optimizers to compare it with.
    """
    rng = np.random.default_rng(SEED)
    reached = np.isfinite(hits["evaluations"].to_numpy(dtype=float))
    paid = np.where(reached, hits["evaluations"], hits["spent"]).astype(float)
    groups: dict[Any, Any] = hits.groupby(["problem", "optimizer"], sort=False, observed=True).indices
    cells = {
        (str(problem), str(label)): (paid[rows], reached[rows])
        for (problem, label), rows in groups.items()
        if label == chosen or label in rivals
    }
    logs = {key: _logarithms(*cell, rng) for key, cell in cells.items()}
    table = []
    for rival in rivals:
        both = [problem for problem, label in cells if label == chosen and (problem, rival) in cells]
        found = {problem: [cells[problem, label][1].any() for label in (chosen, rival)] for problem in both}
        used = [problem for problem, ends in found.items() if any(ends)]
        if not used:
            continue
        drawn = np.mean([logs[problem, rival] - logs[problem, chosen] for problem in used], axis=0)
        least = min(len(cells[problem, label][0]) for problem in used for label in (chosen, rival))
        middle, low, high = drawn[0], np.nan, np.nan
        if least > 1:
            widened = (np.quantile(drawn[1:], (0.025, 0.975)) - middle) * np.sqrt(least / (least - 1))
            low, high = np.exp(middle + np.array([min(widened[0], 0.0), max(widened[1], 0.0)]))
        table.append((rival, len(used), sum(not all(found[each]) for each in used), np.exp(middle), low, high))
    return pd.DataFrame(table, columns=list(COLUMNS))


def _logarithms(paid: Floats, reached: Flags, rng: np.random.Generator) -> Floats:
    """Return the logarithm of the expected running time of a cell, and those of its resamples after it."""
    n = len(paid)
    times = np.vstack([np.ones(n), rng.multinomial(n, np.full(n, 1 / n), size=RESAMPLES)])
    return np.asarray(np.log((times @ paid) / np.maximum(times @ reached, 1)), dtype=np.float64)
