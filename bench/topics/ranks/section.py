"""Tests and effect sizes across problems; each problem counts once."""

from __future__ import annotations

from typing import Any

import pandas as pd

from bench import analysis
from bench.report.parts import Part, Section, Table
from bench.report.wording import count, p_text
from bench.topics.findings import MANY_OPTIMIZERS, Final, Findings
from bench.topics.ranks.figures import forest_figure, rank_figure
from bench.topics.ranks.multiverse import sections as multiverse
from bench.topics.ranks.tables import pair_matrix, ranking_table
from bench.topics.ranks.words import across
from bench.topics.topic import Topic

TITLE = "Across problems"
WINNER = "The pairs of a winner are significant without adjustment, as all of them must be. "
NEMENYI = (
    "As many papers show it (Demšar 2006). This page claims nothing by it: it takes the problems for an independent "
    "sample, knows nothing of the number of trials, and whether two optimizers differ depends on who else is compared "
    "(Benavoli et al. 2016)."
)


def section(findings: Findings) -> Section:
    """Return ranks, tests and effect sizes over all problems; the unit is the problem."""
    medians, optimizers = findings.final.medians, findings.trials.optimizers
    if len(optimizers) < 2:
        return Section(TITLE, ("There is only one optimizer, so there is nothing to compare.",))
    if medians.empty:
        return Section(TITLE, ("No problem has trials of every optimizer, so there is nothing to compare.",))
    left_out = len(findings.trials.problems) - len(medians)
    text = [f"{_friedman(findings.final.friedman)} {across(findings)}"]
    if left_out:
        text.append(
            f"The tests of this part leave out {count(left_out, 'problem')} on which an optimizer has no trial."
        )
    items: list[Part] = [ranking_table(findings)]
    further: list[Section] = []
    if len(medians) > 1 and len(optimizers) > 2:
        ranks = analysis.mean_ranks(findings.final.standings)
        if not findings.final.subject:  # whose rivals no test joins
            items.append(rank_figure(ranks, analysis.cliques(ranks, findings.final.overall)))
        difference, apart = analysis.nemenyi(ranks, len(medians))
        drawn = rank_figure(ranks, analysis.cliques(ranks, apart), difference)
        further.append(Section("The diagram by Nemenyi’s test", (NEMENYI,), (drawn,), folded=True))
    further += multiverse(findings)
    means = _aggregate(analysis.interquartile_mean(findings.trials.frame, findings.trials.optima))
    if len(optimizers) <= MANY_OPTIMIZERS:
        items += [
            forest_figure(findings.final.tested_overall),
            _tests(findings.final),
            means,
        ]
        return Section(TITLE, tuple(text), tuple(items), sections=tuple(further))
    items += [pair_matrix(findings), means]
    tests = _tests(findings.final)
    further.append(Section("Every pair of optimizers", items=(tests,), folded=True))
    return Section(TITLE, tuple(text), tuple(items), sections=tuple(further))


def _friedman(test: dict[str, Any]) -> str:
    if test["note"] == "identical":
        return "All optimizers have the same rank on every problem."
    if test["note"]:
        return f"Friedman’s test is not possible: {test['note']}."
    return (
        f"Friedman’s test of the ranks of {test['optimizers']} optimizers over {test['problems']} "
        f"problems, which is not among the claims of this page: chi-squared = {test['statistic']:.2f}, "
        f"{p_text(test['p'])}; Iman-Davenport F({test['df1']}, {test['df2']}) = {test['iman_davenport']:.2f}, "
        f"{p_text(test['p_iman_davenport'])}."
    )


def _tests(final: Final) -> Table:
    tests, level = final.tested_overall, final.levels.across
    names = {
        "first": "first", "second": "second", "probability": "first lower", "p": "p", "p_holm": "p (Holm)",
        "significant": "significant", "lower": "lower",
    }  # fmt: skip
    shown = tests[list(names)].assign(lower=tests["lower"].where(tests["significant"], ""))
    return Table(
        "pairs-over-problems",
        "The probability of each pair to end lower, in the mean over these problems, and the tests that it is 0.5.",
        shown.rename(columns=names),
        decimals={"first lower": 2},
        note=(f"Significant: p (Holm) of at most {level:g}. " if level else "Nothing is tested over all problems. ")
        + ("" if final.subject else WINNER),
        data=tests.assign(lower=shown["lower"]),
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


TOPIC = Topic(TITLE, section, place=620)
