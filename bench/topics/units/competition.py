"""The table of the CEC competitions and of journals: errors, their tests against one optimizer, and checkpoints."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from bench.analysis.cells import NEAR
from bench.analysis.competition import checkpoint_shares, checkpoints, error_statistics, signs
from bench.report.parts import File, Table, Typography
from bench.topics.findings import Findings
from bench.topics.units import words

SIGNS = {"+": "+", "=": "≈", "-": "−"}
"""The signs as they are printed: a hyphen would be lost as a superscript."""

BY_U_SCORES = ("cec2022", "cec2024")
"""The suites of the competitions whose winners U-scores determined."""


def table(findings: Findings) -> Table | None:
    """Return the table of functions of CEC's suites, and of any study with a subject; None for others."""
    suites = {str(facts.features.get("suite", "")) for facts in findings.trials.known.values()}
    if not findings.subject and not (suites and all(name.startswith("cec") for name in suites)):
        return None
    errors = error_statistics(findings.trials.frame, findings.trials.unbeaten)
    return None if errors.empty else _table(findings, errors, _tests(findings), suites)


def files(findings: Findings) -> Iterator[File]:
    """Yield the file of errors at the competition's checkpoints, where its rules have any."""
    shares = {
        label: checkpoint_shares(str(facts.features.get("suite", "")), findings.trials.dimensions.get(label, 0))
        for label, facts in findings.trials.known.items()
    }
    if findings.trials.traces and any(shares.values()):
        trials = findings.trials
        errors = checkpoints(trials.frame, trials.traces, trials.unbeaten, shares, trials.allowed)
        if len(errors):
            yield File("tables/checkpoints.csv", "Errors at the checkpoints of the competition.", errors)


def _tests(findings: Findings) -> pd.DataFrame:
    """Return the tests of the subject against each other optimizer, none without a subject."""
    if not findings.subject:
        return pd.DataFrame(columns=["problem", "optimizer", "p", "sign"])
    return signs(findings.trials.frame, findings.trials.unbeaten, findings.subject)


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
    known = errors.drop_duplicates("problem")["known"].astype(bool)
    return Table(
        "competition",
        words.caption(findings.trials.common_words, int((~known).sum())),
        frame.rename_axis(index="problem", columns=None),
        Typography(
            texts=pd.concat([texts, last]),
            bold=lowest.reindex(frame.index, fill_value=False),
            marks=marks.reindex(frame.index, fill_value=""),
        ),
        note=" ".join([words.NOTE, *([words.signs(subject, len(tests))] if len(tests) else [])]),
        data=errors.merge(tests, how="left", on=["problem", "optimizer"]),
        totals=len(ends),
        latex=True,
    )


def _cell(mean: float, sd: float) -> str:
    """Return a mean with its standard deviation, three digits each."""
    if pd.isna(mean):
        return "–"
    if np.isinf(mean):
        return "∞"
    return f"{mean:.2e}" + ("" if pd.isna(sd) else f" ({sd:.2e})")
