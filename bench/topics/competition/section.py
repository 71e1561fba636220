"""The table of the CEC competitions and of journals: errors, their tests against one optimizer, and checkpoints."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.analysis.cells import NEAR
from bench.analysis.competition import checkpoint_shares, checkpoints, error_statistics, signs
from bench.analysis.instances import SOLVED
from bench.report.parts import Section, Table
from bench.report.wording import count, listing
from bench.topics.findings import Findings

TITLE = "The competition’s table"
SIGNS = {"+": "+", "=": "=", "-": "−"}
"""The signs as they are printed: a hyphen would be lost as a superscript."""

BY_U_SCORES = ("cec2022", "cec2024")
"""The suites of the competitions whose winners U-scores determined."""


def section(findings: Findings) -> Section | None:
    """Return the tables of functions of CEC's suites, and of any study with a subject; None for others."""
    suites = {str(facts.features.get("suite", "")) for facts in findings.trials.known.values()}
    if not findings.subject and not (suites and all(name.startswith("cec") for name in suites)):
        return None
    errors = error_statistics(findings.trials.frame, findings.trials.unbeaten)
    if errors.empty:
        return None
    tests = (
        signs(findings.trials.frame, findings.trials.unbeaten, findings.subject)
        if findings.subject
        else pd.DataFrame(columns=["problem", "optimizer", "p", "sign"])
    )
    text = [_about(errors, findings.trials.common_words)]
    if findings.subject:
        text.append(_tested(findings.subject, tests))
        if not findings.final.levels.problems:
            text.append(
                "A sign here is no claim of the page, which tests single problems only from "
                f"{findings.final.enough} trials a cell on, at {findings.final.level_on_problems:g} for all together."
            )
    items = [_table(findings, errors, tests, suites), _statistics(errors)]
    shares = {
        label: checkpoint_shares(str(facts.features.get("suite", "")), findings.trials.dimensions.get(label, 0))
        for label, facts in findings.trials.known.items()
    }
    if findings.trials.traces and any(shares.values()):
        items += _checkpoints(findings, shares)
    return Section(TITLE, tuple(text), tuple(items))


def _about(errors: pd.DataFrame, common: str) -> str:
    without = errors.loc[~errors["known"].astype(bool), "problem"].nunique()
    return (
        f"The error of a trial is its best value{f' {common}' if common else ''} less the optimum, and 0 from "
        f"{SOLVED:g} on, as the competitions count it."
        + (
            f" On {count(without, 'problem')} without a known optimum, or where a trial beat it, the table has the "
            "value itself."
            if without
            else ""
        )
    )


def _tested(subject: str, tests: pd.DataFrame) -> str:
    """Explain the signs, and how often they would appear without any difference."""
    meaning = (
        f"+: the errors of {subject} are lower than those of the other optimizer (test of A12 = 0.5, two-sided, "
        "p < 0.05); −: they are higher; =: neither is shown, which is not equality."
    )
    if tests.empty:
        return f"{meaning} No problem has trials of {subject} and of another optimizer."
    return (
        f"{meaning} As the field does, each test is made at 0.05 by itself: nothing is corrected for the "
        f"{count(len(tests), 'test')} of this table. If no optimizer differed from {subject}, about "
        f"{0.05 * len(tests):.2g} of its signs would still be + or − on average, or fewer with few or tied trials. "
        "The verdict and the comparison have tests that are corrected for their number."
    )


def _table(findings: Findings, errors: pd.DataFrame, tests: pd.DataFrame, suites: set[str]) -> Table:
    subject, optimizers = findings.subject, findings.trials.optimizers
    mean, sd = (
        errors.pivot(index="problem", columns="optimizer", values=name)
        .reindex(index=findings.trials.problems, columns=optimizers)
        .astype(float)
        for name in ("mean", "sd")
    )
    cells = {
        optimizer: [_cell(*pair) for pair in zip(mean[optimizer], sd[optimizer], strict=True)]
        for optimizer in optimizers
    }
    texts = pd.DataFrame(cells, index=mean.index)
    sign = tests.pivot(index="problem", columns="optimizer", values="sign").reindex_like(mean)
    marks = sign.replace(SIGNS).where(sign.notna(), "").astype(object)
    best = mean.min(axis=1)
    lowest = mean.sub(best, axis=0).le(NEAR * best.abs(), axis=0) & np.isfinite(mean)
    ends: dict[str, list[str]] = {}
    if subject:
        counts = [" / ".join(str(int((sign[optimizer] == one).sum())) for one in SIGNS) for optimizer in optimizers]
        ends[" / ".join(SIGNS.values())] = [
            "" if optimizer == subject else sign_counts
            for optimizer, sign_counts in zip(optimizers, counts, strict=True)
        ]
    scores = findings.anytime.u_scores if suites <= set(BY_U_SCORES) and len(optimizers) > 1 else pd.DataFrame()
    if len(scores):
        total = scores.groupby("optimizer")["u"].sum()
        ends["U-score"] = [f"{total[optimizer]:,.1f}" for optimizer in optimizers]
    last = pd.DataFrame.from_dict(ends, orient="index", columns=optimizers)
    frame = pd.concat([mean, pd.DataFrame(np.nan, index=last.index, columns=optimizers)]) if ends else mean
    merged = errors.merge(tests, how="left", on=["problem", "optimizer"])
    return Table(
        "competition",
        "Mean and standard deviation of the error"
        + (f", and where {subject} is better (+), not shown to differ (=) or worse (−)" if subject else "")
        + ".",
        frame.rename_axis(index="problem", columns=None),
        texts=pd.concat([texts, last]),
        bold=lowest.reindex(frame.index, fill_value=False),
        marks=marks.reindex(frame.index, fill_value=""),
        note="Mean (standard deviation). Bold: the lowest mean of a row. ∞: a trial failed."
        + (" Each sign: the test of A12 = 0.5 at 0.05, uncorrected; last: their counts." if subject else "")
        + (" U-score: over the problems where all have as many trials." if len(scores) else "")
        + " The CSV file has every statistic and p.",
        data=merged,
        totals=len(ends),
    )


def _cell(mean: float, sd: float) -> str:
    """Return a mean with its standard deviation, three digits each."""
    if pd.isna(mean):
        return "–"
    if np.isinf(mean):
        return "∞"
    return f"{mean:.2e}" + ("" if pd.isna(sd) else f" ({sd:.2e})")


def _statistics(errors: pd.DataFrame) -> Table:
    shown = errors.set_index(["problem", "optimizer"])[["best", "worst", "median", "mean", "sd"]]
    shown = shown.astype(float).rename(columns={"sd": "SD"})
    return Table(
        "competition-statistics",
        "Best, worst, median, mean and standard deviation of the error.",
        shown,
        texts=shown.map(lambda value: _cell(value, np.nan)),
        data=errors,
    )


def _checkpoints(findings: Findings, shares: dict[str, tuple[float, ...]]) -> list[Table]:
    """Return a table of the median errors for each set of checkpoints, which may differ by dimension."""
    tables = []
    for shares_of in dict.fromkeys(filter(None, shares.values())):
        problems = [label for label, of_problem in shares.items() if of_problem == shares_of]
        errors = checkpoints(
            findings.trials.frame[findings.trials.frame["problem"].isin(problems)],
            findings.trials.traces,
            findings.trials.unbeaten,
            shares,
            findings.trials.allowed,
        )
        if errors.empty:
            continue
        dimensions = sorted({findings.trials.dimensions[label] for label in problems})
        wide = errors.pivot(index=["problem", "optimizer"], columns="share", values="median").astype(float)
        order = errors.drop_duplicates(["problem", "optimizer"]).set_index(["problem", "optimizer"]).index
        wide = wide.reindex(order).rename(columns=lambda share: f"{share:.3g}").rename_axis(columns=None)
        where = f"d = {listing([str(dimension) for dimension in dimensions])}"
        tables.append(
            Table(
                f"checkpoints-d{'-'.join(map(str, dimensions))}",
                f"Median error at the competition’s {len(shares_of)} checkpoints, shares of the budget, {where}.",
                wide,
                texts=wide.map(lambda value: "∞" if np.isinf(value) else f"{value:.1e}"),
                note="∞: at most half of the trials had a value by then. The CSV file has every statistic.",
                data=errors,
            )
        )
    return tables
