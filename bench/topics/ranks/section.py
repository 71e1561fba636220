"""Tests and effect sizes across problems; each problem counts once."""

from __future__ import annotations

from bench.analysis.customary import customary, friedman
from bench.report.parts import Part, Section, Table
from bench.report.wording import count
from bench.topics.findings import MANY_OPTIMIZERS, Final, Findings
from bench.topics.ranks.figures import forest_figure
from bench.topics.ranks.tables import pair_matrix, ranking_table
from bench.topics.ranks.words import across

TITLE = "Across problems"
SIGNS = ("optimizer", "better", "alike", "worse")
WINNER = "The pairs of a winner are significant without adjustment, as all of them must be. "


def section(findings: Findings) -> Section:
    """Return ranks, tests and effect sizes over all problems; the unit is the problem."""
    medians, optimizers = findings.final.medians, findings.trials.optimizers
    if len(optimizers) < 2:
        return Section(TITLE, ("There is only one optimizer, so there is nothing to compare.",))
    if medians.empty:
        return Section(TITLE, ("No problem has trials of every optimizer, so there is nothing to compare.",))
    left_out = len(findings.trials.problems) - len(medians)
    text = [across(findings)]
    if left_out:
        text.append(
            f"The tests of this part leave out {count(left_out, 'problem')} on which an optimizer has no trial."
        )
    items: list[Part] = [ranking_table(findings)]
    if len(optimizers) <= MANY_OPTIMIZERS:
        items += [forest_figure(findings.final.tested_overall), _tests(findings.final)]
        return Section(TITLE, tuple(text), tuple(items), sections=(_customary(findings),))
    items.append(pair_matrix(findings))
    every = Section("Every pair of optimizers", items=(_tests(findings.final),), folded=True)
    return Section(TITLE, tuple(text), tuple(items), sections=(every, _customary(findings)))


def _customary(findings: Findings) -> Section:
    """Return the table of the tests that reviewers ask for; its files are what counts."""
    reference = findings.subject or findings.final.ranked[0]
    tests = customary(findings.trials.frame, reference)
    signs = [
        "" if label == reference else f"{better:.0f} / {alike:.0f} / {worse:.0f}"
        for label, better, alike, worse in zip(*(tests[name] for name in SIGNS), strict=True)
    ]
    names = {"optimizer": "optimizer", "mean_rank": "mean rank", "p": "p", "p_holm": "p (Holm)"}
    shown = tests[list(names)].rename(columns=names)
    shown["+ / ≈ / −"], shown["note"] = signs, tests["note"]
    shown = shown.set_index("optimizer").sort_values("mean rank", kind="stable")
    table = Table(
        "customary",
        f"The customary tests of {reference} against each other optimizer, by which this page claims nothing.",
        shown if shown["note"].any() else shown.drop(columns="note"),
        decimals={"mean rank": 2},
        note=f"Ranks are of medians; p: Wilcoxon’s signed ranks of medians; + / ≈ / −: problems on which {reference} "
        "is lower, not shown to differ, or higher (rank-sum test at 0.05, not adjusted). "
        + friedman(findings.trials.frame),
        data=tests,
    )
    return Section("The customary tests", items=(table,), folded=True)


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
