"""The matrix of problems and optimizers."""

from __future__ import annotations

from bench.analysis import ALPHA, comparison_matrix, table
from bench.report.findings import Findings
from bench.report.parts import Section, Table
from bench.report.words import count, shares

TITLE = "Comparison"


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
    lost = findings.coverage.pivot(index="problem", columns="optimizer", values="failed") > 0
    shown = Table(
        "comparison",
        "Median of the best objective value over the trials of each cell (lower is better).",
        values,
        bold=best,
        italic=alike,
        marks=table(matrix, "letters"),
        lost=lost.reindex(index=list(values.index), columns=list(values.columns)),
        note=f"Bold: the lowest median of the row. Italics: an exact Kolmogorov-Smirnov test at {ALPHA:g} (raw p, as "
        "in thesis Table 7.2) cannot tell the result from the best one’s distribution. Letters: optimizers of a row "
        f"that share one are not separable at {ALPHA:g} after Holm’s adjustment. –: no trial; ∞: the median trial "
        "failed; in red with ✗: a cell with failed trials.",
        data=matrix,
    )
    return Section(TITLE, tuple(text), (shown,))


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
