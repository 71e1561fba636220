"""What holds across problems, each problem counting once."""

from __future__ import annotations

from typing import Any

import pandas as pd

from bench.analysis import ALPHA, average_ranks, cliques, critical_difference
from bench.report.findings import Findings
from bench.report.parts import Part, Section, Table
from bench.report.plots import forest_figure, rank_figure
from bench.report.wording import count, p_text

TITLE = "Across problems"


def section(findings: Findings) -> Section:
    """Return ranks, tests and effect sizes over all problems; the unit is the problem, its value the median."""
    medians, optimizers = findings.medians, findings.optimizers
    if len(optimizers) < 2:
        return Section(TITLE, ("There is nothing to compare with only one optimizer.",))
    if medians.empty:
        return Section(TITLE, ("There is nothing to compare: no problem has trials of every optimizer.",))
    left_out = len(findings.problems) - len(medians)
    text = [_friedman(findings.friedman), _suite(findings)]
    if left_out:
        text.append(f"{count(left_out, 'problem')} with a missing cell cannot enter the tests of this part.")
    items: list[Part] = []
    if len(medians) > 1 and len(optimizers) > 2:
        ranks, difference = average_ranks(medians), critical_difference(len(optimizers), len(medians))
        items.append(rank_figure(ranks, cliques(ranks, difference), difference))
        text.append(
            f"In the critical-difference diagram a bar joins optimizers whose average ranks over {len(medians)} "
            f"problems differ by less than {difference:.2f}, what Nemenyi’s test needs at {ALPHA:g}. It is a picture "
            "of the ranks; the tests to rely on are the Wilcoxon tests below it."
        )
    items += [forest_figure(findings.improvement), _wilcoxon(findings.wilcoxon), _aggregate(findings.aggregate)]
    return Section(TITLE, tuple(text), tuple(items))


def _friedman(test: dict[str, Any]) -> str:
    if test["note"] == "identical":
        return "Every optimizer has the same median on every problem: across problems they are identical."
    if test["note"]:
        return f"Friedman’s test is not possible: {test['note']}."
    outcome = "differ" if test["p_iman_davenport"] <= ALPHA else "are not shown to differ"
    return (
        f"Across {test['problems']} problems the ranks of the {test['optimizers']} optimizers {outcome}: Friedman "
        f"chi-squared = {test['statistic']:.2f}, {p_text(test['p'])}; Iman-Davenport "
        f"F({test['df1']}, {test['df2']}) = {test['iman_davenport']:.2f}, {p_text(test['p_iman_davenport'])}."
    )


def _suite(findings: Findings) -> str:
    pairs = findings.pairs
    found = int(pairs["significant_by"].astype(bool).sum())
    return (
        f"Over the whole suite, {found} of {count(len(pairs), 'hypothesis', 'hypotheses')} (pairs times problems) are "
        f"rejected by the Kolmogorov-Smirnov test with the false discovery rate held at {ALPHA:g} under any "
        "dependence (Benjamini-Yekutieli)."
    )


def _wilcoxon(tests: pd.DataFrame) -> Table:
    names = {
        "first": "first", "second": "second", "problems": "problems", "statistic": "W", "p": "p", "p_holm": "p (Holm)",
        "significant": "significant", "lower": "tends lower", "note": "note",
    }  # fmt: skip
    return Table(
        "wilcoxon",
        "Wilcoxon’s signed-rank test of each pair over the problems’ medians, adjusted by Holm.",
        tests[list(names)].rename(columns=names),
        decimals={"W": 1},
        data=tests,
    )


def _aggregate(means: pd.DataFrame) -> Table:
    shown = means.set_index("optimizer")[["problems", "n", "iqm", "low", "high"]]
    return Table(
        "interquartile-mean",
        "Interquartile mean of the normalised error over all problems, with a 95% stratified bootstrap interval: how "
        "far new trials on the same problems would move it.",
        shown.rename(columns={"n": "trials", "iqm": "IQM"}),
        decimals={"IQM": 3, "low": 3, "high": 3},
        note="0 is the optimum of a problem, or the lowest value found where none is known or a trial found less; 1 "
        "is the median of all trials of all optimizers on it. The scale depends on the optimizers compared.",
        data=means,
    )
