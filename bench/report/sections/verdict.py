"""What may be claimed, in one sentence generated from the numbers, and beside it what may not."""

from __future__ import annotations

from math import comb

import pandas as pd

from bench.analysis import ALPHA
from bench.report.findings import Findings
from bench.report.parts import Card, Section, Table
from bench.report.sections import integrity
from bench.report.sections.power import missed
from bench.report.wording import count, listing, losses, p_text

TITLE = "Verdict"


def section(findings: Findings) -> Section:
    """Return the verdict; where there is nothing to compare, a section that says why."""
    ranking = findings.ranking
    if findings.frame.empty:
        return Section(TITLE, warnings=("The study has no trial yet, so there is nothing to say.",))
    lost = losses(findings.frame)
    if len(ranking) < 2:
        return Section(
            TITLE, (f"There is nothing to compare: {findings.optimizers[0]} is the only optimizer.",), lost=lost
        )
    if not ranking["problems"].iloc[0]:
        text = "There is nothing to compare yet: on no problem does every optimizer have a trial."
        return Section(TITLE, (text,), lost=lost)
    cards = (
        Card("What may be claimed", (_claim(findings),), "claim"),
        Card("What may not", _limits(findings), "limit"),
    )
    return Section(TITLE, (_grounds(findings),), (_ranking_table(ranking),), cards=cards, lost=lost)


def _claim(findings: Findings) -> str:
    """Return one sentence: who is ahead, where, on how much evidence, and with how many warnings."""
    study = findings.results.study
    conditions = (
        f"n = {_trials(findings)} with a budget of {count(study.budget, 'evaluation')} on each of "
        f"N = {count(_problems(findings), 'problem')}, alpha = {ALPHA:g}"
    )
    failed = findings.coverage.groupby("optimizer", sort=False, observed=False)["failed"].sum()
    lost = [f"{count(number, 'trial')} of {label}" for label, number in failed.items() if number]
    failures = f"; failed: {listing(lost)}" if lost else ""
    troubles = len(integrity.warnings(findings))
    caveat = f"; mind the {count(troubles, 'warning')} below" if troubles else ""
    return f"{_winner(findings.ranking)} ({conditions}{failures}{caveat})."


def _winner(ranking: pd.DataFrame) -> str:
    problems = int(ranking["problems"].iloc[0])
    ahead = ranking[ranking["first"] > 0].sort_values(["first", "separable"], ascending=False, kind="stable")
    if ahead.empty:
        return "No single winner: on every problem the median trial of every optimizer failed"
    shares = [
        f"{row.optimizer} is ranked first on {row.first} of {count(problems, 'problem')} "
        f"and separable from every rival on {row.separable} of {problems}"
        for row in ahead.itertuples()
    ]
    wins = ranking["separable"].max() * 2 > problems
    return f"{'' if wins else 'No single winner: '}{'; '.join(shares)}"


def _limits(findings: Findings) -> tuple[str, ...]:
    texts = [f"“Not significant” is not “equal”: {missed(findings.trials[0], len(findings.optimizers))}."]
    texts.append(
        f"The counts describe {_these(_problems(findings))} at this budget and with these options; other problems, "
        "budgets or options may rank the optimizers otherwise."
    )
    texts.append(_across(findings))
    return tuple(texts)


def _these(problems: int) -> str:
    return "this one problem" if problems == 1 else f"these {problems} problems"


def _across(findings: Findings) -> str:
    tests, friedman = findings.wilcoxon, findings.friedman
    if (tests["note"] == "untestable").all():
        return (
            f"Nothing can be claimed across problems: {count(_problems(findings), 'problem')} cannot show a difference."
        )
    p = friedman["p_iman_davenport"]
    if not friedman["note"] and p > ALPHA:
        return f"Across the problems no difference is shown (Friedman with Iman-Davenport’s correction, {p_text(p)})."
    pairs = len(tests)
    if pairs > 1 and 2 / 2 ** _problems(findings) > ALPHA / pairs:
        return (
            f"Across the problems no pair can be told apart: {count(_problems(findings), 'problem')} are too few for "
            f"Wilcoxon’s test with Holm’s adjustment over {pairs} pairs."
        )
    open_pairs = [f"{pair.first} and {pair.second}" for pair in tests[~tests["significant"]].itertuples()]
    if not open_pairs:
        return "Across the problems every pair of optimizers differs, but by medians only, not in every trial."
    return f"Across the problems no difference is shown between {listing(open_pairs, at_most=4)} (Wilcoxon, Holm)."


def _grounds(findings: Findings) -> str:
    pairs = comb(len(findings.optimizers), 2)
    adjusted = f", adjusted by Holm over the {pairs} pairs of a problem," if pairs > 1 else ""
    return (
        "First means the lowest median. Separable means that the exact two-sample Kolmogorov-Smirnov test at alpha = "
        f"{ALPHA:g}{adjusted} tells an optimizer from each rival ({count(len(findings.pairs), 'test')} in all), and "
        "that the 95% interval of A12 says it tends to be the lower one. A winner is named only if it is separable "
        "from every rival on more than half of the problems; the counts are over the problems on which every optimizer "
        "has a trial."
    )


def _trials(findings: Findings) -> str:
    low, high = findings.trials
    return count(low, "trial") if low == high else f"{low} to {count(high, 'trial')}"


def _problems(findings: Findings) -> int:
    return int(findings.ranking["problems"].iloc[0])


def _ranking_table(ranking: pd.DataFrame) -> Table:
    problems = int(ranking["problems"].iloc[0])
    shown = ranking[["optimizer", "first", "separable", "mean_rank"]].set_index("optimizer")
    return Table(
        "ranking",
        f"How often each optimizer has the lowest median, of {count(problems, 'problem')}; how often it is then "
        "separable from every rival; and its mean rank.",
        shown.rename(columns={"first": "ranked first", "separable": "separable", "mean_rank": "mean rank"}),
        decimals=2,
    )
