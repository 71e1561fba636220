"""How many times as many evaluations rivals need as a chosen optimizer, over all problems, with an interval.

The logarithm of an expected running time is that of the mean time paid for a run less that of the chance of success.
The first is corrected for its bias by the jackknife (Quenouille 1956, Biometrika 43), of which Student's interval takes
the variance. The second counts half a success more among half a run more, which leaves hardly any bias over many
problems. What runs did not show may happen all the same: the variance is that of the jackknife of n runs times
(n + 1) / (n - 1), without which up to 9% of intervals failed (validation/claims.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import t

from bench.analysis.direction import ALPHA
from bench.contract.typing import Flags, Floats

COLUMNS = ("rival", "problems", "bounded", "ratio", "low", "high")


def ert_ratios(hits: pd.DataFrame, chosen: str, rivals: Sequence[str]) -> pd.DataFrame:
    """Return the geometric mean over problems of a rival's expected running time over that of the chosen optimizer.

    Columns: rival; problems, those that either of the two reaches; bounded, those that only one does: the other enters
    by a bound, all evaluations that its runs spent, as if the last one had just reached it; ratio; and low to high,
    its 95% interval. That ends nowhere above where a rival enters by a bound, at 0 where the chosen one does; it is
    missing where both do, or where a cell has a single run.

    Args:
        hits: hitting times of one target a problem (:func:`bench.analysis.hitting_times`).
        chosen: the optimizer whose time divides the others'.
        rivals: the optimizers to compare it with.
    """
    reached = np.isfinite(hits["evaluations"].to_numpy(dtype=float))
    paid = np.where(reached, hits["evaluations"], hits["spent"]).astype(float)
    groups: dict[Any, Any] = hits.groupby(["problem", "optimizer"], sort=False, observed=True).indices
    cells = {
        (str(problem), str(label)): (*_logarithm(paid[rows], reached[rows]), len(rows) - 1, bool(reached[rows].any()))
        for (problem, label), rows in groups.items()
        if label == chosen or label in rivals
    }
    table = []
    for rival in rivals:
        problems = [problem for problem, label in cells if label == chosen and (problem, rival) in cells]
        pairs = [(cells[problem, chosen], cells[problem, rival]) for problem in problems]
        used = [(own, other) for own, other in pairs if own[3] or other[3]]
        if not used:
            continue
        middle = float(np.mean([other[0] - own[0] for own, other in used]))
        variances, freedom = np.array([cell[1:3] for pair in used for cell in pair]).T
        low = high = np.nan
        open_below, open_above = (not all(pair[side][3] for pair in used) for side in (0, 1))
        if freedom.all() and not (open_below and open_above):
            total = float(variances.sum())
            degrees = total**2 / (variances**2 / freedom).sum() if total else np.inf
            half = float(t.isf(ALPHA / 2, degrees)) * np.sqrt(total) / len(used)
            low, high = 0.0 if open_below else np.exp(middle - half), np.inf if open_above else np.exp(middle + half)
        bounded = sum(not (own[3] and other[3]) for own, other in used)
        table.append((rival, len(used), bounded, np.exp(middle), low, high))
    return pd.DataFrame(table, columns=list(COLUMNS))


def _logarithm(paid: Floats, reached: Flags) -> tuple[float, float]:
    """Return the logarithm of the expected running time of a cell and its variance, missing of a single run."""
    n, successes = len(paid), int(reached.sum())
    chance = np.log((successes + 0.5) / (n + 0.5)) if successes else -np.log(n)
    if n == 1:
        return float(np.log(paid[0])), np.nan
    without = np.log((paid.sum() - paid) / (n - 1))
    estimate = n * np.log(paid.mean()) - (n - 1) * without.mean() - chance
    left = without - np.log((successes - reached + 0.5) / (n - 0.5))
    return float(estimate), float((n + 1) / n * ((left - left.mean()) ** 2).sum())
