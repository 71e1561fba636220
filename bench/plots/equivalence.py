"""Draw the probabilities that the first of two optimizers is better, that both are equal, that the second is better."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.plots import style
from bench.plots.ranks import forest_names

PARTS = {"first_better": "#0072B2", "equal": "#D5D5D5", "second_better": "#E69F00"}
LEGIBLE = 0.08  # of a bar: a smaller part has no number


def equivalence_bars(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw a bar for each pair of :func:`bench.analysis.equivalence.probabilities`, of the signed-rank test."""
    ax = style.own_axes(ax, height=style.rows_height(len(table)) + 0.6)
    at, start = np.arange(len(table)), np.zeros(len(table))
    for column, colour in PARTS.items():
        share = table[column].to_numpy(dtype=float)
        ax.barh(at, share, left=start, color=colour, height=0.7, edgecolor="white", linewidth=0.5)
        for row, (begin, part) in enumerate(zip(start, share, strict=True)):
            if part >= LEGIBLE:
                ink = style.BRIGHT if colour == PARTS["first_better"] else style.DARK
                ax.text(begin + part / 2, row, f"{part:.2f}", ha="center", va="center", color=ink)
        start = start + share
    style.name_rows(ax, forest_names(table))
    ax.set_xlim(0, 1)
    ax.grid(visible=False)
    ax.set_xlabel("probability: first better (left), equal (grey), second better (right)")
    return ax
