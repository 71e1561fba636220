"""Checks of the results themselves, and the trials that failed or are missing."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from bench.analysis.integrity import TRAITS
from bench.objective import ON_TARGET, OUT_OF_TIME
from bench.report.parts import Section, Table
from bench.report.wording import count, listing
from bench.topics.findings import Findings, Trials
from bench.topics.integrity.checks import checks
from bench.topics.integrity.left_out import left_out

TITLE = "Integrity checks"
TROUBLE = ("error", "warning")


def section(findings: Findings) -> Section:
    """Return every check with its finding, and tables of incomplete cells and failures."""
    made = findings.of(checks)
    troubles = made.loc[made["verdict"].isin(TROUBLE), "check"].tolist()
    named = f" ({listing(troubles, len(made))})" if troubles else ""
    unchecked = int((made["verdict"] == "not checked").sum())
    text = (
        f"{count(len(made), 'check')}: {int((made['verdict'] == 'pass').sum())} passed, "
        f"{count(len(troubles), 'warning or error', 'warnings or errors')}{named}"
        + (f", {count(notes, 'note')}" if (notes := int((made["verdict"] == "note").sum())) else "")
        + (f", {unchecked} not possible here" if unchecked else "")
        + "."
    )
    table = Table(
        "integrity",
        "The checks of the results, and what each found.",
        made[["check", "verdict", "finding"]].set_index("check"),
        data=made,
    )
    unseen = (
        f"These results cannot show some traits of an optimizer ({listing([*TRAITS])}): 'bench check' makes separate "
        "runs to look for these. 'bench verify' repeats stored trials."
    )
    apart = ("In these checks every instance is a problem of its own.",) if findings.trials.precisions else ()
    return Section(
        TITLE,
        (text, *apart, unseen),
        (table, *_incomplete(findings.trials)),
        on_demand=True,  # the verdict has the warnings
    )


def warnings(findings: Findings) -> tuple[str, ...]:
    """Return a sentence for each check that found something wrong, which a reader must know before any number."""
    made = findings.of(checks)
    sentences = [
        f"{'Error: ' if row.verdict == 'error' else ''}{str(row.check).capitalize()}: {row.finding}"
        for row in made[made["verdict"].isin(TROUBLE)].itertuples()
    ]
    if reasons := {label: facts.reason for label, facts in findings.trials.known.items() if facts.reason}:
        sentences.append(
            f"{count(len(reasons), 'problem')} cannot be loaded here, so the optimum, the bounds and the expected "
            f"values are unknown: {listing([*reasons], at_most=5)} ({next(iter(reasons.values()))})."
        )
    return (*left_out(findings.trials.comparable), *sentences, *handled(findings.trials.whole))


def handled(frame: pd.DataFrame) -> Iterator[str]:
    """Yield a sentence on evaluations that failed, by problem, and one on trials that a limit of time has ended."""
    sums = frame[["failures", "nfev"]].astype(float).groupby(frame["problem"].astype(object), sort=False).sum()
    shares = (sums["failures"] / sums["nfev"])[sums["failures"] > 0]
    if len(shares):
        named = listing([f"{share:.2g} of those on {problem}" for problem, share in shares.items()], at_most=8)
        yield f"Evaluations failed, and count with the value +inf: a share of {named}."
    if late := int((frame["stop"] == OUT_OF_TIME).sum()):
        yield (
            f"A limit of time has ended {late:,} of {count(len(frame), 'trial')} before the budget: their results "
            "depend on the machine and on what else it did, and cannot be repeated bit by bit."
        )
    if good := int((frame["stop"] == ON_TARGET).sum()):
        yield f"{good:,} of {count(len(frame), 'trial')} ended before the budget, as their value was good enough."


def _incomplete(trials: Trials) -> list[Table]:
    coverage, frame = trials.coverage, trials.whole
    short = coverage[(coverage["missing"] > 0) | (coverage["failed"] > 0)]
    lost = short[["failed"]] > 0
    tables = [Table("incomplete-cells", "Cells with missing or failed trials.", short, lost=lost)] if len(short) else []
    failed = frame[frame["status"] != "ok"]
    return [*tables, _failures(failed)] if len(failed) else tables


def _failures(failed: pd.DataFrame) -> Table:
    first_line = failed["error"].astype(object).where(failed["error"].notna(), "").str.split("\n").str[0]
    errors = failed.assign(optimizer=failed["optimizer"].astype(str), error=first_line)
    reasons = (
        errors.groupby(["optimizer", "status", "error"], sort=False)
        .agg(trials=("trial", "size"), problems=("problem", "nunique"))
        .reset_index()[["optimizer", "status", "trials", "problems", "error"]]
    )
    return Table("failures", "Failed trials by optimizer and reason.", reasons, lost=reasons[["trials"]] > 0)
