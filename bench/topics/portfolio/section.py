"""Which optimizers to take: the virtual best, the smallest set near it, contributions, and the choice by features."""

from __future__ import annotations

from bench.analysis.portfolio import MOST_EXACT, Portfolio, portfolio_of
from bench.errors import BenchError
from bench.report.parts import Section, Table
from bench.report.wording import count, listing
from bench.topics.findings import Findings
from bench.topics.portfolio.choice import Choice, gap_sentence, selection_sentence
from bench.topics.portfolio.figures import portfolio_figure
from bench.topics.topic import Topic

TITLE = "Which optimizers to take"
LEAST_OPTIMIZERS, LEAST_PROBLEMS = 3, 4
MEANING = (
    "What counts is the share of the targets of this report that trials reach within the budget, the mean over trials, "
    "problems and functions; each function counts once. The single best is one optimizer for all problems, the virtual "
    "best the best one for each. Half of the trials choose them, the other half are scored, and both change places: a "
    "virtual best that is scored on the trials that chose it would beat the single best among equal optimizers, too."
)


def section(findings: Findings) -> Section | None:
    """Return the section on the optimizers as a portfolio; None where there are few, or fewer than two trials each."""
    choice = Choice(findings)
    few = len(findings.trials.optimizers) < LEAST_OPTIMIZERS or len(findings.trials.problems) < LEAST_PROBLEMS
    if few or not (choice.scores["score"] > 0).any():
        return None
    try:
        portfolio = portfolio_of(choice.scores, choice.blocks)
    except BenchError:  # too few trials
        return None
    left_out = len(findings.trials.problems) - int(portfolio.gap["problems"].iloc[0])
    text = [MEANING, gap_sentence(portfolio.gap), _smallest(portfolio), selection_sentence(choice)]
    if left_out:
        text.append(f"Left out: {count(left_out, 'problem')} on which an optimizer has fewer than two trials.")
    if findings.trials.decisions.stopped:
        text.append("Looks stopped cells whose difference looked large, which makes differences too large.")
    return Section(TITLE, tuple(text), (portfolio_figure(portfolio), _members(portfolio)))


def _smallest(portfolio: Portfolio) -> str:
    """Return the sentence on the smallest set within 5% of the virtual best."""
    row = portfolio.sets.iloc[-1]
    members = list(row["optimizers"])
    how = (
        "all sets of its size and smaller ones were compared"
        if len(portfolio.members) <= MOST_EXACT
        else "found by adding the optimizer that gains most, one after the other, so a smaller set may exist"
    )
    return (
        f"The smallest set within 5% of the virtual best has {count(len(members), 'optimizer')}, {listing(members)}, "
        f"with {row['score']:.1%} of the targets; {how}."
    )


def _members(portfolio: Portfolio) -> Table:
    members = portfolio.members.sort_values("shapley", ascending=False, kind="stable").set_index("optimizer")
    percent = (100 * members).round(1) + 0.0  # no negative zero
    names = {"score": "alone, %", "chosen": "taken for, %", "shapley": "Shapley value, %", "adds": "adds, %"}
    return Table(
        "portfolio",
        "The contribution of each optimizer to a portfolio of all.",
        percent.rename(columns=names),
        decimals=1,
        note="Alone: the share of the targets that it reaches. Taken for: the share of the problems for which the "
        "virtual best takes it. Shapley value: what it adds to the optimizers before it, averaged over all orders; the "
        "sum is the share that the virtual best reaches. Adds: how much more the virtual best reaches than that of the "
        "others alone, about 0 where another optimizer replaces it.",
        data=members.reset_index(),
    )


TOPIC = Topic(TITLE, section, place=640)
