"""Which optimizers to take: the virtual best, the smallest set near it, contributions, and the choice by features."""

from __future__ import annotations

import pandas as pd

from bench.analysis.portfolio import MOST_EXACT, Portfolio
from bench.errors import BenchError
from bench.plots import style
from bench.plots.portfolio import set_sizes, shapley_rows
from bench.report.findings import Findings
from bench.report.parts import Figure, Section, Table
from bench.report.portfolio import Choice, gap_sentence, selection_sentence
from bench.report.wording import count, listing

TITLE = "Which optimizers to take"
LEAST_OPTIMIZERS, LEAST_PROBLEMS = 3, 4
DRAWN = 30  # optimizers
MEANING = (
    "What counts is the share of the targets of this report that trials reach within the budget, the mean over trials, "
    "problems and functions; each function counts once. The single best is one optimizer for all problems, the virtual "
    "best the best one for each. Half of the trials choose them, the other half are scored, and both change places: a "
    "virtual best that is scored on the trials that chose it would beat the single best among equal optimizers, too."
)


def section(findings: Findings) -> Section | None:
    """Return what the optimizers are worth as a portfolio; None where there are few, or fewer than two trials each."""
    choice = Choice(findings)
    few = len(findings.trials.optimizers) < LEAST_OPTIMIZERS or len(findings.trials.problems) < LEAST_PROBLEMS
    if few or not choice.reached:
        return None
    try:
        found = choice.portfolio
    except BenchError:  # too few trials
        return None
    left_out = len(findings.trials.problems) - int(found.gap["problems"].iloc[0])
    text = [MEANING, gap_sentence(found.gap), _smallest(found), selection_sentence(choice)]
    if left_out:
        text.append(f"Left out: {count(left_out, 'problem')} on which an optimizer has fewer than two trials.")
    if findings.trials.decisions.stopped:
        text.append("Looks stopped cells whose difference looked large, which makes differences too large.")
    validated = choice.validated
    by_problem = (Section("The choice by features, problem by problem", items=(_validation(validated),), folded=True),)
    return Section(TITLE, tuple(text), (_members(found), _figure(found)), sections=by_problem if len(validated) else ())


def _smallest(found: Portfolio) -> str:
    """Return the sentence on the smallest set within 5 % of the virtual best."""
    row = found.sets[found.sets["near"]].iloc[0]
    members, everyone = list(row["optimizers"]), len(found.members)
    how = (
        f"all {2**everyone - 1:,} sets were compared"
        if everyone <= MOST_EXACT
        else "found by adding the optimizer that gains most, one after the other, so a smaller set may exist"
    )
    return (
        f"The smallest set within 5% of the virtual best has {count(len(members), 'optimizer')}, {listing(members)}, "
        f"with {row['score']:.1%} of the targets; {how}."
    )


def _members(found: Portfolio) -> Table:
    own = found.members.sort_values("shapley", ascending=False, kind="stable").set_index("optimizer")
    sampled = bool((own["se"] > 0).any())
    percent = (100 * own[["score", "chosen", "shapley", "adds"]]).round(1) + 0.0  # no negative zero
    names = {"score": "alone, %", "chosen": "taken for, %", "shapley": "Shapley value, %", "adds": "adds, %"}
    texts = [f"{worth:.1f} ± {100 * se:.1f}" for worth, se in zip(percent["shapley"], own["se"], strict=True)]
    return Table(
        "portfolio",
        "The contribution of each optimizer to a portfolio of all.",
        percent.rename(columns=names),
        texts=pd.DataFrame({names["shapley"]: texts}) if sampled else None,
        decimals=1,
        note="Alone: the share of the targets that it reaches. Taken for: the share of the problems for which the "
        "virtual best takes it. Shapley value: what it adds to the optimizers before it, averaged over all orders"
        + (" (200 random ones, ± their standard error)" if sampled else "")
        + "; the sum is the share that the virtual best reaches. Adds: how much more the virtual best reaches "
        "than that of the others alone, about 0 where another optimizer replaces it.",
        data=own.reset_index(),
    )


def _figure(found: Portfolio) -> Figure:
    own = found.members.sort_values("shapley", ascending=False, kind="stable").iloc[:DRAWN]
    left = style.text_width(style.names(own["optimizer"]).values(), style.SMALL) + 0.12
    figure, (rows, sizes) = style.grid(
        2, columns=2, height=max(style.rows_height(len(own)), 1.4), left=left, across=0.7, bottom=0.45, top=0.1
    )
    shapley_rows(own, ax=rows)
    set_sizes(found.sets, ax=sizes)
    names = [" + ".join(members) for members in found.sets["optimizers"]]
    kind = "of the best set of each size" if found.sets["exact"].all() else "of sets, each with one optimizer more"
    data = found.sets.assign(optimizers=names)
    some = f" The first {DRAWN} of {len(found.members)} optimizers are drawn." if len(found.members) > DRAWN else ""
    caption = (
        "Left: the Shapley values. Right: the share of the targets that the virtual best "
        f"{kind} reaches, over that of all; dotted: 5% less.{some}"
    )
    return Figure("portfolio-sets", caption, figure, data, data[["size", "optimizers", "score", "ratio"]])


def _validation(validated: pd.DataFrame) -> Table:
    shown = validated[["problem", "nearest", "distance", "chosen", "score", "single", "single_score"]]
    percent = shown.assign(score=100 * shown["score"], single_score=100 * shown["single_score"])
    names = {
        "nearest": "most similar problem", "score": "reached, %", "single": "single best",
        "single_score": "it reached, %",
    }  # fmt: skip
    return Table(
        "portfolio-selection",
        "What the features would have chosen for each problem, all problems of its function left out.",
        percent.rename(columns=names),
        decimals={"distance": 2, names["score"]: 1, names["single_score"]: 1},
        note="Reached: the share of the targets within the budget less the sample that shows the features.",
        data=validated,
    )
