"""Bars of the mean wall time of a trial."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.plots import style


def timing(table: pd.DataFrame, *, legend: bool = True, ax: Axes | None = None) -> Axes:
    """Draw the mean wall time of one trial of each optimizer, split into the objective and the rest.

    The row of an optimizer without a finished trial has a note instead.

    Args:
        table: columns optimizer, trials, wall_mean and objective_mean in seconds (:func:`bench.analysis.timing`).
        legend: whether to name the two parts above the axes.
        ax: where to draw; by default new axes.
    """
    ax = style.own_axes(ax, height=style.rows_height(len(table)) + 0.7)
    rows = np.arange(len(table))
    wall, objective = table[["wall_mean", "objective_mean"]].fillna(0.0).to_numpy(dtype=float).T
    parts = (("in the objective", 0.0 * wall, objective), ("in the optimizer", objective, wall - objective))
    for (name, start, width), color, hatch in zip(parts, style.PALETTE, style.HATCHES, strict=False):
        ax.barh(rows, width, left=start, height=0.62, color=color, hatch=hatch, edgecolor="white", label=name)
    for row in style.name_rows(ax, list(style.names(table["optimizer"]).values())):
        text = f"{wall[row]:.3g}" if table["trials"].iloc[row] else "none finished"
        ax.annotate(text, (wall[row], row), (3, 0), textcoords="offset points", va="center", fontsize="small")
    style.linear_scale(ax, "x")
    ax.margins(x=0.12)
    ax.set_xlim(left=0.0)
    ax.set_xlabel("mean wall time in s")
    if legend:
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)
    return ax
