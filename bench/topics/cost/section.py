"""The section of the page on what the optimizers cost: evaluations, time a run and time an evaluation."""

from __future__ import annotations

import pandas as pd

from bench.report.parts import Section, Table
from bench.topics.cost import words
from bench.topics.findings import Findings

TITLE = "Cost"
COLUMNS = {
    "evaluations_median": ("evaluations", 1.0), "per_call_median": ("a call", 1.0), "wall_median": ("s a run", 1.0),
    "own_per_evaluation": ("own µs an evaluation", 1e6),
    "objective_per_evaluation": ("objective’s µs an evaluation", 1e6),
    "objective_share": ("objective’s share %", 100.0), "memory_most": ("MB", 1.0),
}  # fmt: skip
"""The columns of :func:`bench.analysis.timing` that the table has, their titles and factors."""


def section(findings: Findings) -> Section | None:
    """Return the table of evaluations and times; None where no time of a finished trial is known."""
    timing = findings.trials.timing
    known = timing[timing["wall_median"].notna()].sort_values("wall_median", kind="stable")
    if known.empty:
        return None
    fastest, slowest = (known.iloc[place] for place in (0, -1))
    text = words.fastest(fastest["optimizer"], fastest["wall_median"], slowest["optimizer"], slowest["wall_median"])
    unknown = words.unknown([*timing.loc[timing["wall_median"].isna(), "optimizer"]])
    return Section(TITLE, tuple(filter(None, (text, unknown))), (_table(known, timing),))


def _table(known: pd.DataFrame, timing: pd.DataFrame) -> Table:
    columns = {title: factor * known[name] for name, (title, factor) in COLUMNS.items() if known[name].notna().any()}
    shown = pd.DataFrame(columns).set_index(pd.Index(known["optimizer"], name="optimizer"))
    return Table(
        "cost",
        "Medians over finished runs: evaluations, those in a call of the objective, and time.",
        shown,
        decimals={"evaluations": 0, "a call": 1, "objective’s share %": 0, "MB": 0},
        note=words.note("MB" in shown),
        data=timing,
    )
