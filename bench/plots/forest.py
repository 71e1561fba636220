"""Forest plots of how often one of two optimizers ends lower."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.analysis.pairwise import CUTOFFS
from bench.plots import style

EFFECTS = [bound for cutoff in CUTOFFS.values() for bound in (1 - cutoff, cutoff)]  # on both sides of 0.5


def a12_forest(rivals: pd.DataFrame, *, names: Sequence[str] | None = None, ax: Axes | None = None) -> Axes:
    """Draw how often an optimizer ends lower than each rival, with its interval, in a row per rival.

    At 0.5 neither tends to be better; the faint lines are the bounds of small, medium and large effects by Vargha and
    Delaney (2000). A point is filled where a test shows a difference.

    Args:
        rivals: of :func:`bench.analysis.compare`, with the intervals of the tests that fill the points.
        names: of the rows; by default those of the rivals.
    """
    ax = style.own_axes(ax, height=style.rows_height(len(rivals)) + 0.6)
    chance, low, high = rivals[["chance", "low", "high"]].to_numpy(dtype=float).T
    at = np.arange(len(rivals))
    ax.vlines(EFFECTS, 0, 1, color="#BBBBBB", linewidth=0.5, linestyle=":", transform=ax.get_xaxis_transform())
    ax.axvline(0.5, color="black", linewidth=0.7)
    ax.hlines(at, low, high, color=style.PALETTE[0], linewidth=1.6)
    clear = (rivals["outcome"] != "open").to_numpy(dtype=bool)
    for which, face in ((clear, style.PALETTE[0]), (~clear, "white")):
        ax.plot(chance[which], at[which], "o", color=style.PALETTE[0], markerfacecolor=face, markersize=4.0, zorder=3)
    style.name_rows(ax, list(style.names(rivals["rival"], 18).values()) if names is None else names)
    ax.set_xlim(-0.03, 1.03)
    ax.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "0.25", "0.5", "0.75", "1"])
    ax.grid(visible=False)
    ax.set_xlabel("chance that the first ends lower\n← second better | first better →")
    return ax
