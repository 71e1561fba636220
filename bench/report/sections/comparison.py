"""The matrix of problems and optimizers."""

from __future__ import annotations

import pandas as pd

from bench.analysis import ALPHA, NEAR, comparison_matrix, regret, table
from bench.report.findings import Findings
from bench.report.parts import Section, Table
from bench.report.wording import count, listing, shares

TITLE = "Comparison"
VALUES = ("mean", "median", "median_low", "median_high", "q1", "q3", "best", "worst")


def section(findings: Findings) -> Section:
    """Return the matrix of medians with the best, what may be as good, and letters."""
    matrix = findings.matrix
    best, alike = table(matrix, "best").astype(bool), table(matrix, "alike").astype(bool)
    if not best.to_numpy().any():
        text = ["No problem has two cells with a finite median, so none is best."]
    else:
        unclear = int(alike.any(axis=1).sum())
        of_them = f"On {unclear} of them" if unclear else "On none of them"
        lowest = (
            f"The lowest median is {shares(best)}. {of_them} the result of an optimizer that is not the best may come "
            "from the best one’s distribution."
        )
        text = [lowest, *_means(findings), *_gaps(findings)]
    values = table(matrix, "value")
    shown = Table(
        "comparison",
        "Median of the best objective value over the trials of each cell (lower is better).",
        values,
        bold=best,
        italic=alike,
        marks=table(matrix, "letters"),
        lost=_lost(findings, values),
        note=f"Bold: the lowest median of the row. Italics: an exact Kolmogorov-Smirnov test at {ALPHA:g} (raw p, as "
        "in thesis Table 7.2) cannot tell the result from the best one’s distribution. Letters: optimizers of a row "
        f"that share one are not separable at {ALPHA:g} after Holm’s adjustment. –: no trial; ∞: the median trial "
        "failed; in red with ✗: a cell with failed trials.",
        data=matrix,
    )
    regrets = regret(findings.summary, findings.unbeaten, VALUES)
    if regrets.empty:
        return Section(TITLE, tuple(text), (shown,))
    return Section(TITLE, (*text, _at_optimum(table(regrets, "median"))), (shown, _regret(findings, regrets)))


def _lost(findings: Findings, shown: pd.DataFrame) -> pd.DataFrame:
    """Return which cells of a table of problems by optimizers have failed trials."""
    return (table(findings.coverage, "failed") > 0).reindex_like(shown)


def _at_optimum(medians: pd.DataFrame) -> str:
    """Return on how many problems the median trial of an optimizer ends at the known optimum."""
    reached = [f"with {label} on {number}" for label, number in medians.eq(0).sum().items() if number]
    of_them = listing(reached) if reached else "with no optimizer"
    return f"The optimum is known on {count(len(medians), 'problem')}; the median trial ends at it {of_them}."


def _regret(findings: Findings, regrets: pd.DataFrame) -> Table:
    medians = table(regrets, "median")
    data = regrets.drop(columns="sd").assign(optimum=regrets["problem"].map(findings.unbeaten))
    return Table(
        "regret",
        "Median regret: the median of the best objective value, less the problem’s optimum.",
        medians,
        lost=_lost(findings, medians),
        note=f"0: at the optimum, to a relative {NEAR:g}; –: no trial; ∞: the median trial failed; in red with ✗: a "
        "cell with failed trials. Problems without a known optimum, or where a trial found less, are left out.",
        data=data,
    )


def _gaps(findings: Findings) -> list[str]:
    """Return a caveat where optimizers were not run on the same problems."""
    empty = findings.coverage[findings.coverage["stored"] == 0]
    gaps = empty.loc[empty["problem"].isin(findings.problems), "problem"].nunique()
    if not gaps:
        return []
    sentence = (
        f"On {count(gaps, 'problem')} an optimizer has no trial: marks there compare the others only, and what sums up "
        "over evaluations or times below rests on different problems for different optimizers."
    )
    return [sentence]


def _means(findings: Findings) -> list[str]:
    """Return a sentence where the mean would crown somebody else: a few bad trials sway it."""
    best = table(findings.matrix, "best").astype(bool)
    by_mean = table(comparison_matrix(findings.summary, findings.pairs, statistic="mean"), "best").astype(bool)
    known = findings.summary.pivot(index="problem", columns="optimizer", values="mean").notna().all(axis=1)
    differ = int((known.loc[best.index] & best.any(axis=1) & ~(best & by_mean).any(axis=1)).sum())
    if not differ:
        return []
    sentence = (
        f"On {count(differ, 'problem')} the lowest mean belongs to another optimizer than the lowest median: a few "
        "trials sway the mean there, so look at the distributions."
    )
    return [sentence]
