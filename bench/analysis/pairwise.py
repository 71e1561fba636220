"""Pairs of optimizers on one problem: the two-sample Kolmogorov-Smirnov test of the thesis, with its safeguards."""

from __future__ import annotations

import warnings
from itertools import combinations
from math import comb
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import ks_2samp
from statsmodels.stats.multitest import multipletests

from bench.analysis.cells import cells, labels
from bench.problem import Floats

ALPHA = 0.05  # thesis section 7.2
TIED = 0.10  # above this share of tied values the test is markedly conservative

COLUMNS = (
    "problem", "first", "second", "n_first", "n_second", "distance", "p", "p_holm", "significant", "a12", "lower",
    "testable", "tied",
)  # fmt: skip


def pairwise_tests(frame: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Return one row a problem and pair of optimizers.

    Columns: distance (the KS statistic D) and its exact p; p_holm, adjusted over the pairs of the problem (Holm
    1979); significant (p_holm <= alpha); a12, the chance that a trial of ``first`` ends below one of ``second``;
    lower, the optimizer it favours ("" at 0.5); testable; tied (more than 10 % of the values are ties).

    Assumptions: trials are independent. Failed trials count as +inf. The exact p holds for continuous values; ties
    make it conservative. A pair that could not be significant whatever its values (too few trials) has p = 1 and is
    marked as not testable; it still counts among the hypotheses.
    """
    found = cells(frame)
    optimizers = labels(frame, "optimizer")
    tables = []
    for problem in labels(frame, "problem"):
        rows = [
            {"problem": problem, "first": a, "second": b, **_compare(found[problem, a], found[problem, b], a, b, alpha)}
            for a, b in combinations(optimizers, 2)
        ]
        if rows:
            adjusted = multipletests([row["p"] for row in rows], method="holm")[1]
            for row, p in zip(rows, adjusted, strict=True):
                tables.append(row | {"p_holm": p, "significant": bool(p <= alpha)})
    return pd.DataFrame(tables, columns=list(COLUMNS))


def a12(this: Floats, other: Floats) -> float:
    """Return the chance that ``this`` is lower than ``other``, ties counted half (Vargha and Delaney 2000).

    Equal to ``mannwhitneyu(other, this).statistic / (n m)``; 0.5 means no tendency, NaN that a sample is empty.
    """
    if not len(this) or not len(other):
        return float("nan")
    gap = np.less.outer(this, other) + 0.5 * np.equal.outer(this, other)
    return float(gap.mean())


def tied_share(values: Floats) -> float:
    """Return the share of values that equal another one, 0 for an empty sample."""
    counts = np.unique(values, return_counts=True)[1]
    return float(counts[counts > 1].sum() / max(len(values), 1))


def _compare(this: Floats, other: Floats, name: str, rival: str, alpha: float) -> dict[str, Any]:
    n, m = len(this), len(other)
    # The smallest exact p that n and m values allow: complete separation, 2 of C(n + m, n) arrangements.
    testable = min(n, m) > 0 and 2 / comb(n + m, n) <= alpha
    chance = a12(this, other)
    distance, p = _kolmogorov_smirnov(this, other) if min(n, m) else (float("nan"), 1.0)
    return {
        "n_first": n,
        "n_second": m,
        "distance": distance,
        "p": p if testable else 1.0,
        "a12": chance,
        "lower": name if chance > 0.5 else rival if chance < 0.5 else "",
        "testable": testable,
        "tied": tied_share(np.concatenate((this, other))) > TIED,
    }


def _kolmogorov_smirnov(this: Floats, other: Floats) -> tuple[float, float]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # scipy warns needlessly at D = 1/n
        result = ks_2samp(this, other, method="exact")
    return float(result.statistic), float(result.pvalue)
