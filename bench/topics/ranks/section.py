"""Tests and effect sizes across problems; each problem counts once."""

from __future__ import annotations

from bench.report.parts import Part, Section, Table
from bench.report.wording import count
from bench.topics.findings import MANY_OPTIMIZERS, Final, Findings
from bench.topics.ranks.figures import forest_figure
from bench.topics.ranks.tables import pair_matrix, ranking_table
from bench.topics.ranks.words import across

TITLE = "Across problems"
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
        return Section(TITLE, tuple(text), tuple(items))
    items.append(pair_matrix(findings))
    every = Section("Every pair of optimizers", items=(_tests(findings.final),), folded=True)
    return Section(TITLE, tuple(text), tuple(items), sections=(every,))


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
