"""A topic of reports: who has the worst run of all, problem by problem."""

import matplotlib.figure
import pandas as pd

from bench.analysis import scores
from bench.report import Figure, Section, Table, Typography, leaders
from bench.topics import Findings

TITLE = "Worst runs"


def worst(findings: Findings) -> pd.DataFrame:
    """Return the worst value of each cell, problems by optimizers; infinite where a run failed."""
    frame = findings.trials.frame
    cells = scores(frame).groupby([frame["problem"].astype(str), frame["optimizer"].astype(str)]).max()
    return cells.unstack().reindex(columns=findings.trials.optimizers)


def section(findings: Findings) -> Section | None:
    """Return the section, None where there is nothing to compare."""
    table = findings.of(worst)
    if table.empty or table.shape[1] < 2:
        return None
    last = table.eq(table.max(axis=1), axis=0)
    return Section(
        TITLE,
        (f"{leaders(last, 'the worst run')}.",),
        (
            Table("worst-runs", "The worst value of each optimizer on each problem.", table, Typography(bold=last)),
            Figure("worst-runs", "On how many problems an optimizer has the worst run.", bars(last), counts(last)),
        ),
    )


def counts(last: pd.DataFrame) -> pd.DataFrame:
    """Return the number of problems on which each optimizer has the worst run."""
    return last.sum().rename_axis("optimizer").reset_index(name="problems")


def bars(last: pd.DataFrame) -> matplotlib.figure.Figure:
    """Draw these numbers as bars."""
    figure = matplotlib.figure.Figure(figsize=(3.5, 0.4 + 0.25 * last.shape[1]), layout="constrained")
    ax = figure.subplots()
    ax.barh(list(last.columns), last.sum())
    ax.set_xlabel("problems")
    return figure
