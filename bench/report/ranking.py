"""The ranking as tables: the rank of every optimizer on every problem as a map, and the ranking over all problems."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pandas as pd

from bench import analysis
from bench.report.findings import Findings
from bench.report.parts import LIKE_FRAME, Table
from bench.report.wording import count

MOST_PAIRED = 30  # optimizers of a matrix of pairs
NEAR = "≈"  # beside the rank of an optimizer that no test separates from the first


def rank_map(findings: Findings) -> Table:
    """Return the rank of each optimizer on each problem, darker for a better one; optimizers in order of mean rank.

    Many optimizers, or those of long names, are the rows, as they do not fit beside each other.
    """
    order = findings.ranked
    ranks = analysis.table(findings.standings, "rank")[order]
    texts = ranks.map(lambda rank: "" if pd.isna(rank) else f"{rank:g}").astype(object)
    best = analysis.table(findings.matrix, "best").astype(bool)[order]
    marks = (_beside_first(findings)[order] & ~best).map(lambda near: NEAR if near else "")
    shades = (ranks - 1) / max(len(order) - 1, 1)
    note = (
        f"Bold: ranked first. {NEAR}: no test separates it from the first. Ties share their mean rank; empty: no trial."
    )
    caption = "Rank of each optimizer on each problem, by the rivals that it beats."
    if not findings.upright:
        return Table(
            "rank-map", caption, texts.rename_axis("problem"), bold=best, marks=marks, shades=shades,
            axes=("problem", "optimizer"), note=note, data=findings.standings,
        )  # fmt: skip
    return Table(
        "rank-map", caption, texts.T.rename_axis("optimizer"), bold=best.T, marks=marks.T, shades=shades.T,
        axes=("optimizer", "problem"), note=note, data=findings.standings,
    )  # fmt: skip


def pair_matrix(findings: Findings) -> Table:
    """Return the chance that a run of the row ends lower than one of the column, the best optimizers in their order."""
    order, pairs = findings.ranked[:MOST_PAIRED], findings.improvement
    wide = pairs.pivot(index="first", columns="second", values="probability").reindex(
        index=findings.optimizers, columns=findings.optimizers
    )
    chances = wide.fillna(1 - wide.T).loc[order, order]
    tests = findings.overall[findings.overall["significant"]]
    clear = pd.DataFrame(False, index=order, columns=order)
    for first, second in zip(tests["first"], tests["second"], strict=True):
        if first in clear.index and second in clear.index:
            clear.at[first, second] = clear.at[second, first] = True
    texts = chances.map(lambda chance: "" if pd.isna(chance) else f"{chance:.2f}").astype(object)
    left = len(findings.optimizers) - len(order)
    rest = f" The {len(order)} best by mean rank; the file has the {left} others." if left else ""
    return Table(
        "pair-matrix",
        "The chance that a run of the optimizer of the row ends lower than one of that of the column, averaged over "
        f"problems.{rest}",
        texts.rename_axis(index="optimizer", columns=None),
        bold=clear,
        shades=1 - chances,
        note="Bold: the pair differs significantly across problems (Wilcoxon, Holm).",
        data=pairs,
    )


def turned(table: Table, findings: Findings) -> Table:
    """Return a table of problems by optimizers with the optimizers as rows, best first, where there are many.

    Columns that are no optimizers are left out.
    """
    if not findings.upright:
        return table
    order = [label for label in findings.ranked if label in table.frame]

    def turn(frame: pd.DataFrame) -> pd.DataFrame:
        return frame.reindex(columns=order).T.rename_axis("optimizer")

    named = {name: getattr(table, name) for name in LIKE_FRAME}
    swapped: dict[str, Any] = {name: turn(frame) for name, frame in named.items() if frame is not None}
    note = table.note.replace("the row", "the column").replace("a row", "a column")
    return replace(table, note=note, **swapped)


def _beside_first(findings: Findings) -> pd.DataFrame:
    """Return which optimizers no test separates from a first one of the problem, problems by optimizers."""
    best = analysis.table(findings.matrix, "best").astype(bool)
    pairs = findings.pairs[findings.pairs["lower"] == ""]
    pairs = pairs[pairs[["n_first", "n_second"]].min(axis=1) > 0]
    row = best.index.get_indexer(pd.Index(pairs["problem"]))
    first, second = (best.columns.get_indexer(pd.Index(pairs[name])) for name in ("first", "second"))
    known = best.to_numpy()
    near = known.copy()
    for one, other in ((first, second), (second, first)):
        beside = known[row, one]
        near[row[beside], other[beside]] = True
    return pd.DataFrame(near, index=best.index, columns=best.columns)


def ranking_table(findings: Findings) -> Table:
    """Return the mean ranks and first places with their intervals, best first."""
    table = findings.ranking.merge(findings.certainty.drop(columns="problems"), on="optimizer")
    table = table.set_index("optimizer").loc[findings.ranked]
    problems, sure = int(table["problems"].iloc[0]), bool(table["rank_low"].notna().all())
    rank = table["mean_rank"]
    shown = pd.DataFrame(
        {
            "mean rank": _with_interval(rank, table["rank_low"], table["rank_high"]) if sure else rank,
            "first": table["first"],
            "separable": table["separable"],
            "worse": table["worse"],
        },
        index=table.index,
    )
    return Table(
        "ranking",
        f"The ranking over {count(problems, 'problem')}.",
        shown,
        decimals=2,
        note=("In brackets: a 95% interval of the mean rank that other trials on these problems would give. " * sure)
        + "First: problems on which it is ranked first, unless half of the optimizers or more share that place; "
        "separable: on which it is separably lower than every rival; "
        "worse: on which a rival is separably lower than it.",
        data=table.reset_index(),
    )


def _with_interval(values: pd.Series[Any], low: pd.Series[Any], high: pd.Series[Any]) -> list[str]:
    return [f"{one:.2f} [{least:.2f}, {most:.2f}]" for one, least, most in zip(values, low, high, strict=True)]
