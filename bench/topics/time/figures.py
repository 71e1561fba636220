"""The time of a trial."""

from __future__ import annotations

import pandas as pd

from bench.plots import style, timing
from bench.report.parts import Figure
from bench.topics.figures import MOST_ROWS, figure_width, left_margin


def timing_figure(table: pd.DataFrame) -> Figure:
    """Return the mean time of one trial of each optimizer (thesis Fig. 7.5), split into objective and the rest."""
    shown = table.nsmallest(MOST_ROWS, "wall_mean") if len(table) > MOST_ROWS else table
    left = left_margin(style.names(shown["optimizer"]).values())
    figure, (ax,) = style.grid(1, width=figure_width(left), height=style.rows_height(len(shown)), left=left, top=0.25)
    timing(shown, ax=ax)
    data = table[["optimizer", "trials", "wall_mean", "objective_mean"]]
    some = f" The {len(shown)} fastest of {len(table)} are drawn." if len(shown) < len(table) else ""
    caption = f"Mean wall time of one trial of each optimizer over all problems.{some}"
    return Figure("mean-time", caption, figure, data)
