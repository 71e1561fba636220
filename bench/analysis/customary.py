"""The tests that reviewers ask for, made by scipy: mean ranks with Friedman's test, signed ranks, + ≈ −.

A page makes no claim by them. They take the problems for an independent sample, one median for each, and know nothing
of the number of runs (Demšar 2006, Journal of Machine Learning Research 7; Derrac, García, Molina and Herrera 2011,
Swarm and Evolutionary Computation 1).
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.stats import friedmanchisquare, mannwhitneyu, wilcoxon

from bench.analysis.cells import cells, labels, summarise
from bench.analysis.direction import ALPHA
from bench.analysis.matrix import medians
from bench.analysis.pairwise import holm
from bench.contract.typing import Floats

COLUMNS = ("optimizer", "problems", "mean_rank", "p", "p_holm", "better", "alike", "worse", "note")


def customary(frame: pd.DataFrame, reference: str) -> pd.DataFrame:
    """Return one row an optimizer: its mean rank, and the tests of the ``reference`` against it.

    Columns: optimizer; problems, those on which every optimizer has a trial; ``mean_rank`` of the medians, 1 for the
    lowest; ``p`` of Wilcoxon's signed-rank test of the medians of the reference and of this optimizer, and p_holm,
    adjusted over the rivals; ``better``, ``alike`` and ``worse``: on how many problems Wilcoxon's rank-sum test of the
    runs, at 0.05 and not adjusted, shows the reference to be lower (+), neither (≈), or higher (−); ``note``, why there
    is no p. All but optimizer, problems and mean_rank are missing for the reference.
    """
    middle, runs = medians(summarise(frame)), cells(frame, merge=True)
    ranks, rivals = middle.rank(axis=1).mean(), [label for label in middle if label != reference]
    tests = {label: _signed_ranks(middle[reference], middle[label]) for label in rivals}
    known = [label for label, (p, _) in tests.items() if not np.isnan(p)]
    adjusted = dict(zip(known, holm(np.array([tests[label][0] for label in known])), strict=True))
    rows = []
    for label in labels(frame, "optimizer"):
        row = {"optimizer": label, "problems": len(middle), "mean_rank": ranks.get(label, np.nan)}
        if label in tests:
            signs = [_sign(runs[problem, reference], runs[problem, label]) for problem in middle.index]
            p, note = tests[label]
            row |= {"p": p, "p_holm": adjusted.get(label, np.nan), "note": note}
            row |= {name: signs.count(sign) for name, sign in (("better", 1), ("alike", 0), ("worse", -1))}
        rows.append(row)
    return pd.DataFrame(rows, columns=list(COLUMNS)).fillna({"note": ""})


def friedman(frame: pd.DataFrame) -> str:
    """Return a sentence with Friedman's test of the ranks of medians, or on why it is not possible."""
    middle = medians(summarise(frame))
    problems, optimizers = middle.shape
    if optimizers < 3 or problems < 2:
        return "Friedman's test is not possible: it needs three optimizers and two problems or more."
    if middle.eq(middle.iloc[:, 0], axis=0).all(axis=None):
        return "Friedman's test is not possible: all medians of a problem are equal."
    ranks = middle.rank(axis=1).to_numpy()
    found = friedmanchisquare(*ranks.T)
    return (
        f"Friedman's test of {optimizers} optimizers on {problems} problems: chi-squared = {found.statistic:.2f} with "
        f"{optimizers - 1} degrees of freedom, p = {found.pvalue:.2g}."
    )


def _signed_ranks(reference: pd.Series[float], rival: pd.Series[float]) -> tuple[float, str]:
    """Return the p of Wilcoxon's signed-rank test over problems and "", or NaN and why it is not possible."""
    if not (np.isfinite(reference) & np.isfinite(rival)).all():
        return np.nan, "a median is infinite, as half of its runs failed"
    apart = (reference - rival).to_numpy(dtype=float)
    if np.count_nonzero(apart) < 6:
        return np.nan, "fewer than six problems differ, so no p could be below 0.05"
    return float(wilcoxon(apart).pvalue), ""


def _sign(reference: Floats, rival: Floats) -> int:
    """Return 1 where a rank-sum test shows the reference to be lower, -1 where it is higher, else 0."""
    if min(len(reference), len(rival)) < 2 or np.unique([*reference, *rival]).size == 1:
        return 0
    test = mannwhitneyu(reference, rival)
    below = test.statistic < len(reference) * len(rival) / 2
    return 0 if test.pvalue > ALPHA else 1 if below else -1
