"""The verdict: who is best, by how much, how sure that is and at what budget, with the ranks on every problem."""

from __future__ import annotations

from collections import Counter
from math import comb

import numpy as np

from bench import analysis
from bench.analysis import ALPHA
from bench.budget import described
from bench.report.conditions import sentences
from bench.report.findings import Findings
from bench.report.parts import Card, Part, Section
from bench.report.plots import course_figure
from bench.report.ranking import rank_map, ranking_table
from bench.report.sections import integrity
from bench.report.sections.power import detectable_differences
from bench.report.sections.trials import NOT_ADJUSTED, extension_text
from bench.report.target_words import TargetWords
from bench.report.winner import TIED, Stage, Standing, paragraph, too_few_problems
from bench.report.wording import count, listing, p_text, unfinished_trials

TITLE = "Verdict"
NEAR = 0.01  # of the best known value


def section(findings: Findings) -> Section:
    """Return the verdict, or a section that states why there is nothing to compare."""
    if findings.frame.empty:
        return Section(TITLE, warnings=("The study has no trial yet, so there is no verdict.",))
    lost, warnings = unfinished_trials(findings.frame), integrity.warnings(findings)
    nothing = ""
    if len(findings.ranking) < 2:
        nothing = f"There is nothing to compare: {findings.optimizers[0]} is the only optimizer."
    elif not len(findings.medians):
        nothing = "There is nothing to compare yet: no problem has trials of every optimizer."
    if nothing:
        return Section(TITLE, (nothing,), lost=lost, warnings=warnings)
    conditions = sentences(findings.study, findings.descriptions)
    cards = (
        Card("What may be claimed", (paragraph(standing(findings)), _conditions(findings)), "claim"),
        Card("What may not be claimed", (*_limits(findings), *conditions.limits), "limit", folded=True),
        Card("How this is decided", (_grounds(findings), *conditions.others), "limit", folded=True),
    )
    items: list[Part] = [rank_map(findings)]
    if findings.traces and len(findings.stages):
        items.append(course_figure(findings.stages, findings.looks))
    items.append(ranking_table(findings))
    return Section(TITLE, (), tuple(items), warnings, cards=cards, lost=lost)


def standing(findings: Findings) -> Standing:
    """Return what the paragraph is written from."""
    complete = list(findings.medians.index)
    ranking = findings.ranking.merge(findings.certainty.drop(columns="problems"), on="optimizer")
    clear = findings.pairs[findings.pairs["problem"].isin(complete) & (findings.pairs["p_holm"] <= ALPHA)]
    beaten: Counter[tuple[str, str]] = Counter()
    for first, second, lower in zip(clear["first"], clear["second"], clear["lower"], strict=True):
        if lower:
            beaten[str(lower), str(second if lower == first else first)] += 1
    chances: dict[tuple[str, str], tuple[float, float, float]] = {}
    for pair in findings.improvement.to_dict("records"):
        first, second, chance, low, high = (pair[name] for name in ("first", "second", "probability", "low", "high"))
        chances[first, second], chances[second, first] = (chance, low, high), (1 - chance, 1 - high, 1 - low)
    known = all(label in findings.unbeaten for label in complete)
    best = "the optimum" if known else "the best known value"
    precise = findings.words.kind == "precisions"  # a share of an optimum that was shifted at will means nothing
    least, most = findings.trials
    return Standing(
        ranking, beaten, chances, findings.testable,
        budget=described(findings.study.budget),
        problem=str(complete[0]) if len(complete) == 1 else "",
        found=analysis.near_best(findings.frame, findings.optima, 0.0 if precise else NEAR, analysis.SOLVED),
        near=f"within {analysis.SOLVED:g} of {best}" if precise else f"within {NEAR:.0%} of {best}",
        course=_course(findings),
        unit="of the budget" if findings.scaled else "evaluations",
        clock=_clock(findings),
        trials=count(least, "trial") if least == most else f"{least} to {count(most, 'trial')}",
    )  # fmt: skip


def _course(findings: Findings) -> list[Stage]:
    """Return who has the lowest mean rank at the budgets of the figure beside the paragraph."""
    if not findings.traces:
        return []
    stages = findings.stages
    means = stages.pivot_table(index="share", columns="optimizer", values="rank", sort=False, observed=True)
    spent = stages.drop_duplicates("share")["evaluations"]
    course = []
    for (share, own), evaluations in zip(means.iterrows(), spent, strict=True):
        lowest = own.index[np.isclose(own, own.min(), rtol=0, atol=TIED)]
        text = f"{float(str(share)):.0%}" if findings.scaled else f"{evaluations:,}"
        course.append(Stage(text, tuple(map(str, lowest))))
    return course


def _clock(findings: Findings) -> str:
    """Return who reaches the targets first in seconds, where that is another one than in evaluations; else ""."""
    words, table = findings.words, findings.running_times
    if table.empty:
        return ""
    solved = table.loc[table["successes"] > 0, words.unit].unique().tolist()
    level = words.level if words.level in solved else min(solved, default=np.nan)
    own = table[table[words.unit] == level]
    if own.empty:
        return ""
    first = []
    for name in ("ert", "ert_s"):
        reached = analysis.table(own, name).astype(float).replace(np.inf, np.nan)
        first.append(reached.eq(reached.min(axis=1), axis=0).sum())
    evaluations, seconds = first
    leader, fastest = str(evaluations.idxmax()), str(seconds.idxmax())
    problems = own["problem"].nunique()
    if leader == fastest or 2 * min(evaluations[leader], seconds[fastest]) <= problems:
        return ""  # an order is turned round only where there is one, on most problems
    return (
        f"By the clock the order turns round: to the target {_target(words, level)}, {leader} has the lowest expected "
        f"running time in evaluations on {evaluations[leader]} of {count(problems, 'problem')}, but {fastest} has the "
        f"lowest in seconds on {seconds[fastest]} ({leader} on {seconds[leader]})."
    )


def _target(words: TargetWords, level: float) -> str:
    share = f" ({100 * level:g}% of the first distance)" if words.kind == "relative" else ""
    return f"{words.at(level)}{share}"


def _conditions(findings: Findings) -> str:
    """Return on how much evidence the paragraph rests."""
    study = findings.study
    low, high = findings.trials
    trials = count(low, "trial") if low == high else f"{low} to {count(high, 'trial')}"
    failed = findings.coverage.groupby("optimizer", sort=False, observed=False)["failed"].sum()
    lost = [f"{count(number, 'trial')} of {label}" for label, number in failed.items() if number]
    return (
        f"n = {trials} of at most {described(study.budget)} on each of N = {count(len(findings.medians), 'problem')}, "
        f"alpha = {ALPHA:g}; in brackets: 95% bootstrap intervals"
        + (f"; failed: {listing(lost)}" if lost else "")
        + "."
    )


def _limits(findings: Findings) -> tuple[str, ...]:
    problems = len(findings.medians)
    counted = "this one problem" if problems == 1 else f"these {problems} problems"
    power = detectable_differences(findings.trials[0], len(findings.optimizers))
    texts = [
        f"“Not significant” does not mean “equal”: {power}.",
        f"The counts describe {counted} at this budget and with these options; others may give another ranking.",
        across(findings),
    ]
    texts += extension_text(findings)
    if findings.decisions.stopped:
        texts.append(NOT_ADJUSTED)
    if looked := findings.results.looked:
        texts.append(
            f"The runs in {listing(looked)} were stopped by declared looks; the tests of this comparison do not "
            "account for these, so their p-values are too small."
        )
    if findings.allowed != findings.budgets:
        unequal = (
            "The optimizers had different budgets, and the ranks of final values favour the larger ones: compare the "
            "running times to targets instead."
        )
        texts.insert(0, unequal)
    return tuple(filter(None, (*texts, dependent(findings), unused(findings))))


def unused(findings: Findings) -> str:
    """Return who left a part of the budget unused, which restarts could have spent; "" where nobody did."""
    own = findings.unused[findings.unused["unused"] > 0.01].sort_values("unused", ascending=False, kind="stable")
    if own.empty:
        return ""
    shown = [f"{label} {share:.0%}" for label, share in zip(own["optimizer"], own["unused"], strict=True)]
    return (
        f"A part of the budget was left unused (mean share): {listing(shown, at_most=5)}. These trials ended by a "
        "criterion of the optimizer, without a restart; what they would find with the rest is not known."
    )


def across(findings: Findings) -> str:
    """Return what the tests across problems do not show."""
    tests, friedman, problems = findings.wilcoxon, findings.friedman, len(findings.medians)
    p, pairs = friedman["p_iman_davenport"], len(tests)
    if not friedman["note"] and p <= ALPHA:
        start = f"Some optimizers differ across problems (Friedman, {p_text(p)}), but no pair can be distinguished"
    else:
        start = "No pair of optimizers can be distinguished across problems"
    if (tests["note"] == "untestable").all():
        return f"{start}: too few problems ({problems} in all) show a difference for Wilcoxon’s test to be significant."
    if not friedman["note"] and p > ALPHA:
        return f"The tests show no difference across problems (Friedman with Iman-Davenport’s correction, {p_text(p)})."
    if pairs > 1 and too_few_problems(problems, pairs):
        return (
            f"{start}: {problems} problems are too few for Wilcoxon’s test with Holm’s adjustment over {pairs} pairs."
        )
    apart = tests[~tests["significant"]]
    if apart.empty:
        return "Every pair of optimizers differs significantly across problems, but in the medians, not in every trial."
    open_pairs = [f"{first} and {second}" for first, second in zip(apart["first"], apart["second"], strict=True)]
    return f"The tests show no difference across problems between {listing(open_pairs, at_most=4)} (Wilcoxon, Holm)."


def dependent(findings: Findings) -> str:
    """Return which problems are no independent sample; "" where none is known to be."""
    ranked = set(findings.medians.index)
    steps = {name: len(ranked & set(own)) for name, own in findings.sweeps.items()}
    which = [f"{number} of {len(ranked)} problems are steps of one sweep, {name}" for name, number in steps.items()]
    if not which:
        return ""
    return (
        f"The problems are not independent samples: {listing(which)}. Neighbouring steps resemble each other, so "
        "counts and p-values across problems describe this sweep, and overstate the evidence for other problems."
    )


def _grounds(findings: Findings) -> str:
    pairs, looks = comb(len(findings.optimizers), 2), findings.results.study.looks
    over = [f"for looks at {listing([str(each) for each in looks])} trials"] if looks else []
    over += [f"by Holm’s method over the {pairs} pairs of a problem"] if pairs > 1 else []
    adjusted = f" (adjusted {' and '.join(over)})" if over else ""
    return (
        "On a problem, optimizers rank by the number of rivals that they beat: more than half of the pairs of a trial "
        "of one and a trial of the other end lower with it (A12 > 0.5). One is separably lower than another if the "
        f"exact two-sample Kolmogorov-Smirnov test rejects equality at alpha = {ALPHA:g}{adjusted} and the 95% "
        f"interval of A12 excludes 0.5 ({count(len(findings.pairs), 'test')} in all). The order over all problems is "
        "that of the mean ranks. A winner is named only if it is separably lower than each rival on more than half of "
        "the problems. The counts are over the problems on which every optimizer has a trial. Smaller budgets "
        "are the points of the figure of mean ranks; those at which the first one shares the lowest are not named."
    )
