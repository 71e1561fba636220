"""Tests and effect sizes across problems; each problem counts once."""

from __future__ import annotations

from typing import Any

import pandas as pd

from bench import analysis
from bench.analysis import ALPHA
from bench.report.findings import MANY_OPTIMIZERS, Findings
from bench.report.parts import Part, Section, Table
from bench.report.plots import forest_figure, rank_figure
from bench.report.ranking import pair_matrix
from bench.report.sections.verdict import across, dependent
from bench.report.wording import count, p_text

TITLE = "Across problems"


def section(findings: Findings) -> Section:
    """Return ranks, tests and effect sizes over all problems; the unit is the problem."""
    medians, optimizers = findings.final.medians, findings.trials.optimizers
    if len(optimizers) < 2:
        return Section(TITLE, ("There is only one optimizer, so there is nothing to compare.",))
    if medians.empty:
        return Section(TITLE, ("No problem has trials of every optimizer, so there is nothing to compare.",))
    left_out = len(findings.trials.problems) - len(medians)
    text = [
        f"{_friedman(findings.final.friedman)} {across(findings)}",
        *filter(None, [dependent(findings)]),
    ]
    if left_out:
        text.append(
            f"The tests of this part leave out {count(left_out, 'problem')} on which an optimizer has no trial."
        )
    items: list[Part] = []
    if len(medians) > 1 and len(optimizers) > 2:
        ranks = analysis.mean_ranks(findings.final.standings)
        items.append(rank_figure(ranks, analysis.cliques(ranks, findings.final.overall)))
    means = _aggregate(analysis.interquartile_mean(findings.trials.frame, findings.trials.optima))
    if len(optimizers) <= MANY_OPTIMIZERS:
        items += [
            forest_figure(findings.final.improvement),
            _tests(findings.final.overall, findings.final.levels.further),
            means,
        ]
        return Section(TITLE, tuple(text), tuple(items))
    items += [pair_matrix(findings), means]
    pairs = Section(
        "Every pair of optimizers", items=(_tests(findings.final.overall, findings.final.levels.further),), folded=True
    )
    return Section(TITLE, tuple(text), tuple(items), sections=(pairs,))


def _friedman(test: dict[str, Any]) -> str:
    if test["note"] == "identical":
        return "All optimizers have the same rank on every problem."
    if test["note"]:
        return f"Friedman’s test is not possible: {test['note']}."
    outcome = "differ significantly" if test["p_iman_davenport"] <= ALPHA else "do not differ significantly"
    return (
        f"The ranks of the {test['optimizers']} optimizers over {test['problems']} problems {outcome}: Friedman "
        f"chi-squared = {test['statistic']:.2f}, {p_text(test['p'])}; Iman-Davenport "
        f"F({test['df1']}, {test['df2']}) = {test['iman_davenport']:.2f}, {p_text(test['p_iman_davenport'])}."
    )


def _tests(tests: pd.DataFrame, further: bool) -> Table:
    names = {
        "first": "first", "second": "second", "blocks": "independent problems", "statistic": "W" if further else "z",
        "p": "p",
        "p_holm": "p (Holm)",
        "significant": "significant", "lower": "lower", "note": "note",
    }  # fmt: skip
    shown = tests[list(names)].assign(lower=tests["lower"].where(tests["significant"], ""))
    return Table(
        "wilcoxon" if further else "mean-over-problems",
        "Wilcoxon’s signed-rank test of each pair on A12 − 0.5 of independent problems, adjusted by Holm’s method."
        if further
        else "The test of each pair that the mean of A12 over these problems is 0.5, adjusted by Holm’s method.",
        shown.rename(columns=names),
        decimals={"W": 1, "z": 2},
        data=tests,
    )


def _aggregate(means: pd.DataFrame) -> Table:
    shown = means.set_index("optimizer")[["problems", "n", "iqm", "low", "high"]]
    return Table(
        "interquartile-mean",
        "Interquartile mean of the normalised error over all problems, with a 95% stratified bootstrap interval, "
        "which shows how far new trials on the same problems would move the mean.",
        shown.rename(columns={"n": "trials", "iqm": "IQM"}),
        decimals={"IQM": 3, "low": 3, "high": 3},
        note="0 is the optimum of a problem, or the lowest value found where the optimum is unknown or beaten; 1 is "
        "the median of all trials of all optimizers on the problem. The scale depends on the optimizers compared.",
        data=means,
    )
