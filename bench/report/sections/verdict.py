"""The verdict: one sentence on what the numbers support, and the limits of that claim."""

from __future__ import annotations

from math import comb

import pandas as pd

from bench.analysis import ALPHA
from bench.budget import described
from bench.report.conditions import sentences
from bench.report.findings import Findings
from bench.report.parts import Card, Section, Table
from bench.report.sections import integrity
from bench.report.sections.power import detectable_differences
from bench.report.wording import count, listing, p_text, unfinished_trials

TITLE = "Verdict"
MOST_NAMED = 5  # optimizers that the claim names; the table below it has all


def section(findings: Findings) -> Section:
    """Return the verdict, or a section that states why there is nothing to compare."""
    ranking = findings.ranking
    if findings.frame.empty:
        return Section(TITLE, warnings=("The study has no trial yet, so there is no verdict.",))
    lost = unfinished_trials(findings.frame)
    if len(ranking) < 2:
        return Section(
            TITLE, (f"There is nothing to compare: {findings.optimizers[0]} is the only optimizer.",), lost=lost
        )
    if not len(findings.medians):
        text = "There is nothing to compare yet: no problem has trials of every optimizer."
        return Section(TITLE, (text,), lost=lost)
    cards = (
        Card("What may be claimed", (_claim(findings),), "claim"),
        Card(
            "What may not be claimed", (*_limits(findings), *sentences(findings.study, findings.descriptions)), "limit"
        ),
    )
    return Section(TITLE, (_grounds(findings),), (_ranking_table(ranking),), cards=cards, lost=lost)


def _claim(findings: Findings) -> str:
    """Return one sentence: which optimizer leads where, on how much evidence, and with how many warnings."""
    study = findings.study
    low, high = findings.trials
    trials = count(low, "trial") if low == high else f"{low} to {count(high, 'trial')}"
    conditions = (
        f"n = {trials} of at most {described(study.budget)} on each of "
        f"N = {count(len(findings.medians), 'problem')}, alpha = {ALPHA:g}"
    )
    failed = findings.coverage.groupby("optimizer", sort=False, observed=False)["failed"].sum()
    lost = [f"{count(number, 'trial')} of {label}" for label, number in failed.items() if number]
    failures = f"; failed: {listing(lost)}" if lost else ""
    troubles = len(integrity.warnings(findings))
    caveat = f"; see the {count(troubles, 'warning')} below" if troubles else ""
    return f"{_winner(findings.ranking)} ({conditions}{failures}{caveat})."


def _winner(ranking: pd.DataFrame) -> str:
    problems = int(ranking["problems"].iloc[0])
    ahead = ranking[ranking["first"] > 0].sort_values(["first", "separable"], ascending=False, kind="stable")
    if ahead.empty:
        return "No single winner: the median trial of every optimizer failed on every problem"
    shares = [
        f"{row.optimizer} is ranked first on {row.first} of {count(problems, 'problem')} "
        f"and separable from every rival on {row.separable} of {problems}"
        for row in ahead.itertuples()
    ]
    wins = ranking["separable"].max() * 2 > problems
    text = "; ".join(shares) if len(ahead) <= MOST_NAMED else _in_short(ahead, problems)
    return f"{'' if wins else 'No single winner: '}{text}"


def _in_short(ahead: pd.DataFrame, problems: int) -> str:
    """Return the counts of the first of many optimizers, and the largest of the others."""
    first, *named = ahead.iloc[: MOST_NAMED - 1].itertuples()
    rest = ahead.iloc[MOST_NAMED - 1 :]
    leading = f"{first.optimizer} is ranked first on {first.first} of {count(problems, 'problem')}"
    shares = [
        f"{leading} (and separable from every rival on {first.separable})",
        *(f"{row.optimizer} on {row.first} ({row.separable})" for row in named),
        f"{len(rest)} others on at most {rest['first'].max()} ({rest['separable'].max()}) each",
    ]
    return listing(shares) + ("; a tie counts for each" if ahead["first"].sum() > problems else "")


def _limits(findings: Findings) -> tuple[str, ...]:
    problems = len(findings.medians)
    counted = "this one problem" if problems == 1 else f"these {problems} problems"
    power = detectable_differences(findings.trials[0], len(findings.optimizers))
    scope = (
        f"The counts describe {counted} at this budget and with these options; other problems, budgets or options may "
        "give another ranking."
    )
    text = f"“Not significant” does not mean “equal”: {power}."
    if findings.allowed != findings.budgets:
        unequal = (
            "The optimizers had different budgets, and the ranks of final values favour the larger ones: compare the "
            "running times to targets instead."
        )
        return unequal, text, scope, _across(findings)
    return text, scope, _across(findings)


def _across(findings: Findings) -> str:
    """Return what the tests across problems do not show."""
    tests, friedman, problems = findings.wilcoxon, findings.friedman, len(findings.medians)
    if (tests["note"] == "untestable").all():
        return (
            f"No pair of optimizers can be distinguished across problems: too few problems ({problems} in all) show a "
            "difference for Wilcoxon’s test to be significant."
        )
    p = friedman["p_iman_davenport"]
    if not friedman["note"] and p > ALPHA:
        return f"The tests show no difference across problems (Friedman with Iman-Davenport’s correction, {p_text(p)})."
    pairs = len(tests)
    if pairs > 1 and 2 / 2**problems > ALPHA / pairs:
        return (
            f"No pair of optimizers can be distinguished across problems: {problems} problems are too few for "
            f"Wilcoxon’s test with Holm’s adjustment over {pairs} pairs."
        )
    open_pairs = [f"{pair.first} and {pair.second}" for pair in tests[~tests["significant"]].itertuples()]
    if not open_pairs:
        return "Every pair of optimizers differs significantly across problems, but in the medians, not in every trial."
    return f"The tests show no difference across problems between {listing(open_pairs, at_most=4)} (Wilcoxon, Holm)."


def _grounds(findings: Findings) -> str:
    pairs = comb(len(findings.optimizers), 2)
    adjusted = f" (adjusted by Holm’s method over the {pairs} pairs of a problem)" if pairs > 1 else ""
    return (
        "An optimizer is ranked first on a problem if it beats the most rivals: more than half of the pairs of a trial of "
        "it and one of the rival end lower with it (A12 > 0.5). It is separable from a rival if the "
        f"exact two-sample Kolmogorov-Smirnov test rejects equality at alpha = {ALPHA:g}{adjusted} and the 95% "
        f"interval of A12 shows a tendency to lower values ({count(len(findings.pairs), 'test')} in all). A single "
        "winner is named only if it is separable from every rival on more than half of the problems. The counts are "
        "over the problems on which every optimizer has a trial."
    )


def _ranking_table(ranking: pd.DataFrame) -> Table:
    problems = int(ranking["problems"].iloc[0])
    shown = ranking[["optimizer", "first", "separable", "mean_rank"]].set_index("optimizer")
    return Table(
        "ranking",
        f"On how many of {count(problems, 'problem')} each optimizer is ranked first, on how many it is separably lower "
        "than every rival, and its mean rank over all of them.",
        shown.rename(columns={"first": "ranked first", "mean_rank": "mean rank"}),
        decimals=2,
    )
