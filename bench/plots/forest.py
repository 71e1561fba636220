"""Forest plots of how often one of two optimizers ends lower."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.analysis.pairwise import CUTOFFS
from bench.plots import style

EFFECTS = [bound for cutoff in CUTOFFS.values() for bound in (1 - cutoff, cutoff)]  # on both sides of 0.5


def a12_forest(
    pairs: pd.DataFrame, problem: str | None = None, *, names: Sequence[str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw how often the first of two optimizers does better, with its interval, in a row per pair.

    At 0.5 neither tends to be better; the faint lines are the bounds of small, medium and large effects by Vargha and
    Delaney (2000). A point is filled where its pair is significant.

    Args:
        pairs: the rivals of :func:`bench.analysis.comparison.compare`, or pairs of
            :func:`bench.analysis.pairwise_tests`, with the intervals of the tests that fill the points.
        problem: the label of the problem to draw, where ``pairs`` has several.
        names: of the rows; by default the rivals, or "A vs B".
    """
    rows = pairs if problem is None else style.rows_of(pairs, problem)
    ax = style.own_axes(ax, height=style.rows_height(len(rows)) + 0.6)
    against = "outcome" in rows
    number = "chance" if against else "a12"
    chance, low, high = rows[[number, "low", "high"]].to_numpy(dtype=float).T
    at = np.arange(len(rows))
    ax.vlines(EFFECTS, 0, 1, color="#BBBBBB", linewidth=0.5, linestyle=":", transform=ax.get_xaxis_transform())
    ax.axvline(0.5, color="black", linewidth=0.7)
    ax.hlines(at, low, high, color=style.PALETTE[0], linewidth=1.6)
    clear = (rows["outcome"] != "open" if against else rows["significant"]).to_numpy(dtype=bool)
    for which, face in ((clear, style.PALETTE[0]), (~clear, "white")):
        ax.plot(chance[which], at[which], "o", color=style.PALETTE[0], markerfacecolor=face, markersize=4.0, zorder=3)
    if names is None:
        names = list(style.names(rows["rival"], 18).values()) if against else forest_names(rows)
    style.name_rows(ax, names)
    ax.set_xlim(-0.03, 1.03)
    ax.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "0.25", "0.5", "0.75", "1"])
    ax.grid(visible=False)
    ax.set_xlabel("chance that the first ends lower\n← second better | first better →")
    return ax


def forest_names(pairs: pd.DataFrame) -> list[str]:
    """Return the labels of the rows of a forest plot."""
    names = style.names(dict.fromkeys([*pairs["first"], *pairs["second"]]), 18)
    return [f"{names[first]} vs {names[second]}" for first, second in zip(pairs["first"], pairs["second"], strict=True)]
