"""The map of ranks: a row a problem, or above 40 problems a column a class; never wider than the page."""

from __future__ import annotations

import pandas as pd

from bench.plots import style
from bench.report.parts import Table, Typography
from bench.topics.findings import Findings
from bench.topics.runs.marks import FIRST, NEAR, marks, ranks_on
from bench.topics.runs.panels import MOST, classes

HEAD, CLASS = 20, 28  # letters of an optimizer, and of a problem or class
COLUMNS = 12  # most columns of the map beside the names of its rows


def rank_map(findings: Findings) -> Table:
    """Return the rank of each optimizer on each problem, or its mean rank on each class; darker is better."""
    trials, shown = findings.trials, findings.display.shown
    by_class = len(trials.problems) > MOST
    places = classes(trials) if by_class else {label: [label] for label in trials.problems}
    ranks = ranks_on(findings.final, places).reindex(columns=shown).dropna(how="all")
    marked = marks(findings.final, places).reindex(index=ranks.index, columns=shown).fillna("")
    near = marked == NEAR
    every = len(trials.optimizers)
    notes = ["Bold: the first. Equal optimizers get the mean of their ranks."]
    notes += [f"{NEAR}: no test separates it from the first."] if near.any(axis=None) else []
    notes += [f"The file has all {every} optimizers."] if len(shown) < every else []
    found = Table(
        "rank-map",
        f"{'Mean rank of each optimizer on each class' if by_class else 'Rank of each optimizer on each problem'}, by "
        "the chance to end lower.",
        ranks.map(lambda rank: "" if pd.isna(rank) else f"{rank:.1f}" if by_class else f"{rank:g}").astype(object),
        Typography(
            bold=marked == FIRST,
            marks=near.map(lambda beside: NEAR if beside else ""),
            shades=(ranks - 1) / max(every - 1, 1),
        ),
        note=" ".join(notes),
        data=findings.final.chances,
        latex=True,
    )
    heads, rows = style.names(shown, HEAD), style.names(ranks.index, CLASS)
    if by_class and len(ranks) <= COLUMNS:
        turned = found.arranged(lambda frame: frame.rename(index=rows, columns=heads).T)
        return turned.arranged(lambda frame: frame.rename_axis(index="optimizer", columns=None))
    return found.arranged(lambda frame: frame.rename(columns=heads).rename_axis("class" if by_class else "problem"))
