"""The matrix of medians, problems by optimizers, and their regret."""

from __future__ import annotations

import pandas as pd

from bench.analysis import ALPHA, NEAR, comparison_matrix, regret, table
from bench.report.findings import Findings
from bench.report.parts import Section, Table
from bench.report.sections import feasibility
from bench.report.wording import count, leaders, listing

TITLE = "Comparison"
VALUES = ("mean", "median", "median_low", "median_high", "q1", "q3", "best", "worst")


def section(findings: Findings) -> Section:
    """Return the matrix of medians, its best values, those not distinguishable from them, and letters."""
    matrix = findings.matrix
    best, alike = table(matrix, "best").astype(bool), table(matrix, "alike").astype(bool)
    if not best.to_numpy().any():
        text = ["No problem has both a finite median and a rival for it, so no best optimizer is marked."]
    else:
        unclear = int(alike.any(axis=1).sum())
        test = (
            f"On {unclear} of these problems an exact Kolmogorov-Smirnov test (raw p) cannot distinguish an optimizer "
            "with the lowest median from another one."
            if unclear
            else "An exact Kolmogorov-Smirnov test (raw p) distinguishes the optimizers with the lowest median from "
            "all others on each of these problems."
        )
        lowest = f"{leaders(best, 'the lowest median')}. {test}"
        text = [lowest, *filter(None, (_means(findings), _gaps(findings)))]
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
        "in thesis Table 7.2) cannot distinguish the result from the best one. Letters: optimizers of a row that share "
        f"a letter are not separable at {ALPHA:g} after Holm’s adjustment. –: no trial; ∞: the median trial failed; in "
        "red with ✗: a cell with failed trials.",
        data=matrix,
    )
    regrets = regret(findings.summary, findings.unbeaten, VALUES)
    items = [shown]
    if len(regrets):
        text.append(_at_optimum(table(regrets, "median")))
        above = regrets[~regrets["problem"].isin(findings.pooled.functions)]  # their values are regrets already
        items += [_regret(findings, above)] if len(above) else []
    feasible = feasibility.sections(findings)
    if findings.many:
        each = Section("Each problem", items=tuple(items), folded=True)
        return Section(TITLE, tuple(text), sections=(each, *feasible))
    return Section(TITLE, tuple(text), tuple(items), sections=feasible)


def _lost(findings: Findings, shown: pd.DataFrame) -> pd.DataFrame:
    """Return which cells of a table of problems by optimizers have failed trials."""
    return (table(findings.coverage, "failed") > 0).reindex_like(shown)


def _at_optimum(medians: pd.DataFrame) -> str:
    """Return on how many problems the median trial of each optimizer reached the known optimum."""
    reached = [f"on {number} with {label}" for label, number in medians.eq(0).sum().items() if number]
    outcome = f"The median trial reached it {listing(reached)}" if reached else "No optimizer’s median trial reached it"
    return f"The optimum is known on {count(len(medians), 'problem')}. {outcome}."


def _regret(findings: Findings, regrets: pd.DataFrame) -> Table:
    medians = table(regrets, "median")
    data = regrets.drop(columns="sd").assign(optimum=regrets["problem"].map(findings.unbeaten))
    return Table(
        "regret",
        "Median regret: the median of the best objective value minus the optimum of the problem.",
        medians,
        lost=_lost(findings, medians),
        note=f"0: at the optimum within a relative {NEAR:g}; –: no trial; ∞: the median trial failed; in red with ✗: a "
        "cell with failed trials. Problems without a known optimum, or with a trial below it, are left out.",
        data=data,
    )


def _gaps(findings: Findings) -> str:
    """Return a caveat where the optimizers were not run on the same problems, else ""."""
    empty = findings.coverage[findings.coverage["stored"] == 0]
    gaps = empty.loc[empty["problem"].isin(findings.problems), "problem"].nunique()
    if not gaps:
        return ""
    return (
        f"On {count(gaps, 'problem')} at least one optimizer has no trial. The marks there compare the others only, "
        "and the summaries over evaluations and times below cover different problems for different optimizers."
    )


def _means(findings: Findings) -> str:
    """Return a caveat where the lowest mean and the lowest median disagree: a few bad trials sway a mean; else ""."""
    best = table(findings.matrix, "best").astype(bool)
    by_mean = table(comparison_matrix(findings.summary, findings.pairs, statistic="mean"), "best").astype(bool)
    known = findings.summary.pivot(index="problem", columns="optimizer", values="mean").notna().all(axis=1)
    differ = int((known.loc[best.index] & best.any(axis=1) & ~(best & by_mean).any(axis=1)).sum())
    if not differ:
        return ""
    return (
        f"On {count(differ, 'problem')} the optimizer with the lowest mean does not have the lowest median: a few "
        "trials sway the mean there, so look at the distributions."
    )
