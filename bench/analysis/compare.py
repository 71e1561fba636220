"""Summaries of cells and pairs: the thesis's comparison matrix, compact letters, and the number of first ranks."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pandas as pd

from bench.analysis.across import average_ranks
from bench.analysis.cells import merge_near_ties
from bench.analysis.pairwise import ALPHA


def comparison_matrix(
    summary: pd.DataFrame,
    pairs: pd.DataFrame,
    statistic: Literal["median", "mean"] = "median",
    alpha: float = ALPHA,
) -> pd.DataFrame:
    """Return the matrix of thesis Table 7.2, one row a cell: problem, optimizer, value, best and alike.

    ``value`` is the statistic, missing where it is not known. ``best`` (bold in the thesis) marks the lowest finite
    value of a problem, each of them where several tie, in problems with at least two values. ``alike`` (italics)
    marks a known value that is not best, where the test cannot separate its cell from a best one: as in the thesis, by
    the raw p > ``alpha``; an untestable pair (p = 1) counts as alike. The letters of
    :func:`compact_letters` summarise all pairs after Holm's adjustment; merge them with this table.

    The ``statistic`` is "median", or "mean" as in the thesis, which is missing after a single failed trial. ``pairs``
    hold at least the optimizers of ``summary``.
    """
    values = table(summary, statistic)
    best = _lowest(values) & (values.notna().sum(axis=1) > 1).to_numpy()[:, np.newaxis]
    winners = {(problem, optimizer) for optimizer in best for problem in best.index[best[optimizer]]}
    near = {
        (pair.problem, one)
        for pair in pairs[pairs["p"] > alpha].itertuples()
        for one, other in ((pair.first, pair.second), (pair.second, pair.first))
        if (pair.problem, other) in winners
    } - winners
    cells = list(zip(summary["problem"], summary["optimizer"], strict=True))
    return summary[["problem", "optimizer"]].assign(
        value=summary[statistic],
        best=[cell in winners for cell in cells],
        alike=summary[statistic].notna() & np.array([cell in near for cell in cells], dtype=bool),
    )


def compact_letters(summary: pd.DataFrame, pairs: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Return problem, optimizer and letters of every cell (Piepho 2004, J. Comput. Graph. Stat. 13).

    Two optimizers share a letter where they are not separable: p_holm > ``alpha``. Letters are assigned from the lowest
    median up, so the best has an "a". "" stands for a cell without trials, "?" for every cell of a problem that needs
    more than 52 letters. Only the optimizers of ``summary`` get letters.
    """
    letters = {
        (problem, optimizer): text
        for problem, own in summary[summary["n"] > 0].groupby("problem", sort=False)
        for optimizer, text in _letters(
            list(own.sort_values("median", kind="stable")["optimizer"]), pairs[pairs["problem"] == problem], alpha
        ).items()
    }
    cells = summary[["problem", "optimizer"]]
    return cells.assign(letters=[letters.get(cell, "") for cell in cells.itertuples(index=False, name=None)])


def _letters(optimizers: list[str], pairs: pd.DataFrame, alpha: float) -> dict[str, str]:
    """Return the letters of each optimizer of one problem, the first one's from "a" on."""
    from scikit_posthocs import compact_letter_display  # slow: it imports the drawing libraries

    place = {optimizer: i for i, optimizer in enumerate(optimizers)}
    alike = np.ones((len(place), len(place)))
    for first, second, p in zip(pairs["first"], pairs["second"], pairs["p_holm"], strict=True):
        if first in place and second in place:
            i, j = place[first], place[second]
            alike[i, j] = alike[j, i] = p > alpha  # the library's own rule differs at p = alpha
    try:
        shown = compact_letter_display(alike, alpha=0.5, names=optimizers)
    except ValueError:  # more groups than letters
        return dict.fromkeys(optimizers, "?")
    return {optimizer: text.replace(" ", "") for optimizer, text in shown.items()}


def ranking(summary: pd.DataFrame, pairs: pd.DataFrame, alpha: float = ALPHA) -> pd.DataFrame:
    """Return one row an optimizer: problems, first, separable and mean_rank.

    The unit is the problem, its value the median score, as in :func:`medians`. ``first`` counts the problems with
    the lowest median (a tie counts for each), ``separable`` those of them where the optimizer differs from every
    rival (KS, Holm) and tends to be lower than each (``lower`` of :func:`bench.analysis.pairwise_tests`).
    """
    median = medians(summary)
    first = _lowest(median)
    beats = pairs[(pairs["p_holm"] <= alpha) & (pairs["lower"] != "")].groupby(["problem", "lower"]).size().to_dict()
    rivals = max(len(median.columns) - 1, 1)  # with no rival at all nothing is separable
    separable = [
        sum(beats.get((problem, optimizer)) == rivals for problem in median.index[first[optimizer]])
        for optimizer in median.columns
    ]
    return pd.DataFrame(
        {
            "optimizer": list(median.columns),
            "problems": len(median),
            "first": first.sum().to_numpy(),
            "separable": separable,
            "mean_rank": average_ranks(median).to_numpy(),
        }
    )


def table(long: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return a column of a table with one row a cell as problems by optimizers, both in the order of its rows."""
    order = {key: list(dict.fromkeys(long[key])) for key in ("problem", "optimizer")}
    wide = long.pivot(index="problem", columns="optimizer", values=column)
    return wide.reindex(index=order["problem"], columns=order["optimizer"]).rename_axis(columns=None)


def medians(summary: pd.DataFrame) -> pd.DataFrame:
    """Return the median scores, problems by optimizers, of the problems on which every optimizer has a trial.

    A median is +inf where half of the trials failed. Near-ties on a problem are ties, so that two optimizers at the
    same optimum rank alike.
    """
    return _tied(table(summary, "median").dropna())


def _tied(values: pd.DataFrame) -> pd.DataFrame:
    """Return the table with near-ties within each row made ties."""
    rows = [merge_near_ties(row) for row in values.to_numpy(dtype=float)]
    return pd.DataFrame(np.reshape(rows, values.shape), index=values.index, columns=values.columns)


def _lowest(values: pd.DataFrame) -> pd.DataFrame:
    """Return which cells hold the lowest value of their row, ties included; none where that is not finite."""
    tied = _tied(values)
    lowest = tied.min(axis=1)
    return tied.eq(lowest.where(np.isfinite(lowest)), axis=0)
