"""Mean ranks, and the chance of each pair, over all problems."""

from __future__ import annotations

import pandas as pd

from bench.plots import a12_forest, style
from bench.plots.ranks import forest_names
from bench.report.parts import Figure
from bench.topics.figures import figure_width, left_margin


def forest_figure(pairs: pd.DataFrame) -> Figure:
    """Return the probability of each pair to end lower over all problems, with its intervals and its test."""
    left = left_margin(forest_names(pairs))
    height = style.rows_height(len(pairs))
    figure, (ax,) = style.grid(1, width=figure_width(left), height=height, left=left, bottom=0.5, top=0.08)
    a12_forest(pairs, ax=ax)
    caption = (
        "The probability that a run of the first optimizer ends lower than one of the second, averaged over these "
        "problems, with 95% intervals that hold for all pairs together. A point is filled where the test on these "
        "problems is significant (Holm). Dotted: the bounds of small, medium and large effects on both sides of 0.5."
    )
    return Figure("probability-to-end-lower", caption, figure, pairs)
