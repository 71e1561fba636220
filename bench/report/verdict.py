"""The verdict in words, generated from the numbers: no more than they say."""

from __future__ import annotations

import pandas as pd

from bench.analysis import ALPHA, critical_distance, detectable_shift
from bench.report.findings import Findings
from bench.report.parts import Section, Table
from bench.report.words import count, listing


def verdict(findings: Findings) -> Section:
    """Return who is ahead, on what grounds, what the tests could not have seen, and what is wrong with the data."""
    ranking = findings.ranking
    if findings.frame.empty:
        return Section("Verdict", warnings=("The study has no trial yet, so there is nothing to say.",))
    items: tuple[Table, ...] = ()
    if len(ranking) < 2:
        text: tuple[str, ...] = (f"There is nothing to compare: {ranking['optimizer'].iloc[0]} is the only optimizer.",)
    elif not ranking["problems"].iloc[0]:
        text = ("There is nothing to compare yet: on no problem does every optimizer have a trial.",)
    else:
        text = (_winner(ranking), _grounds(findings), _power(findings))
        items = (_ranking_table(ranking),)
    return Section("Verdict", text, items, warnings=tuple(_warnings(findings)))


def completeness(findings: Findings) -> list[Section]:
    """Return a section on incomplete cells and failed trials, or none where all is well."""
    coverage = findings.coverage
    short = coverage[(coverage["missing"] > 0) | (coverage["failed"] > 0)]
    if short.empty:
        return []
    items = [Table("incomplete-cells", "Cells with missing or failed trials.", short)]
    failed = findings.frame[findings.frame["status"] != "ok"]
    if len(failed):
        first_line = failed["error"].astype(object).where(failed["error"].notna(), "").str.split("\n").str[0]
        errors = failed.assign(optimizer=failed["optimizer"].astype(str), error=first_line)
        reasons = (
            errors.groupby(["optimizer", "status", "error"], sort=False)
            .agg(trials=("trial", "size"), problems=("problem", "nunique"))
            .reset_index()[["optimizer", "status", "trials", "problems", "error"]]
        )
        items.append(Table("failures", "Failed trials by optimizer and reason.", reasons))
    return [Section("Missing and failed trials", items=tuple(items))]


def _winner(ranking: pd.DataFrame) -> str:
    problems = int(ranking["problems"].iloc[0])
    ahead = ranking[ranking["first"] > 0].sort_values(["first", "separable"], ascending=False, kind="stable")
    if ahead.empty:
        return "No single winner: on every problem the median trial of every optimizer failed."
    shares = [
        f"{row.optimizer} is ranked first on {row.first} of {count(problems, 'problem')} "
        f"and separable from every rival on {row.separable} of {problems}"
        for row in ahead.itertuples()
    ]
    wins = ranking["separable"].max() * 2 > problems
    return f"{'' if wins else 'No single winner: '}{'; '.join(shares)}."


def _grounds(findings: Findings) -> str:
    study, coverage = findings.results.study, findings.coverage
    stored = coverage.loc[coverage["stored"] > 0, "stored"]
    low, high = int(stored.min()), int(stored.max())
    trials = f"{low}" if low == high else f"{low} to {high}"
    pairs = len(findings.optimizers) * (len(findings.optimizers) - 1) // 2
    return (
        f"First means the lowest median over n = {trials} trials with a budget of {count(study.budget, 'evaluation')}; "
        f"the counts are over the N = {count(int(findings.ranking['problems'].iloc[0]), 'problem')} on which every "
        "optimizer has a trial. Separable means that the exact two-sample Kolmogorov-Smirnov test at alpha = "
        f"{ALPHA:g}, adjusted by Holm over the {count(pairs, 'pair')} of a problem, tells it from each rival and "
        "that it tends to be the lower one "
        f"({count(len(findings.pairs), 'test')} in all). A winner is "
        "named only if it is separable from every rival on more than half of the problems. The counts describe these "
        "problems; no test across problems is made here."
    )


def _power(findings: Findings) -> str:
    stored = findings.coverage.loc[findings.coverage["stored"] > 0, "stored"]
    n, pairs = int(stored.min()), len(findings.optimizers) * (len(findings.optimizers) - 1) // 2
    steps = [(ALPHA, f"alpha = {ALPHA:g}")]
    if pairs > 1:
        steps.append((ALPHA / pairs, f"the first Holm step ({ALPHA / pairs:.2g})"))
    parts, shifts = [], []
    for alpha, name in steps:
        needed, shift = critical_distance(n, alpha), detectable_shift(n, alpha)
        if needed is None or shift is None:
            parts.append(f"at {name} no difference at all can be found")
        else:
            parts.append(
                f"at {name} the test needs D of at least {needed}/{n} and sees 80% of shifts of {shift:.2f} SD"
            )
            shifts.append(f"{shift:.1f}")
    ending = (
        f"“not significant” therefore reads “shifts below about {' to '.join(dict.fromkeys(shifts))} SD would often be "
        "missed”, never “equal”."
        if shifts
        else "the trials are too few for any test: “not significant” says nothing."
    )
    return f"With n = {n}, the smallest number of trials in a cell, {'; '.join(parts)}: {ending}"


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


def _warnings(findings: Findings) -> list[str]:
    coverage, pairs, frame = findings.coverage, findings.pairs, findings.frame
    empty, failed, stored = (coverage["stored"] == 0), coverage["failed"].sum(), coverage["stored"].sum()
    found = []
    if empty.any():
        found.append(f"{empty.sum()} of {count(len(coverage), 'cell')} have no trial: {_named(coverage[empty])}.")
    if coverage.loc[~empty, "missing"].any():
        planned = findings.results.study.trials
        found.append(f"The study is not finished: {stored} of {planned * len(coverage)} planned trials are stored.")
    if coverage.loc[~empty, "stored"].nunique() > 1:
        found.append("The cells hold unequal numbers of trials, so that tests differ in what they can see.")
    if failed:
        found.append(
            f"{failed} of {count(int(stored), 'trial')} failed or ended without a finite value, in "
            f"{_named(coverage[coverage['failed'] > 0])}. They count as worse than any other; their cells have no mean."
        )
    silent = frame.loc[frame["stop"] == "undeclared", "optimizer"].astype(str)
    if len(silent):
        found.append(
            f"{count(len(silent), 'trial')} of {listing(list(silent.unique()))} ended early without saying why."
        )
    if untestable := (~pairs["testable"].astype(bool)).sum():
        found.append(
            f"{untestable} of {count(len(pairs), 'pair')} cannot be significant whatever the values, as the trials "
            "are too few; p is set to 1."
        )
    if tied := pairs["tied"].astype(bool).sum():
        found.append(
            f"In {tied} of {count(len(pairs), 'pair')} more than 10% of the values are ties; their p is on the safe "
            "side (too large)."
        )
    return found


def _named(cells: pd.DataFrame) -> str:
    return listing([f"{cell.optimizer} on {cell.problem}" for cell in cells.itertuples()], at_most=5)
