"""The mean ranks over the number of trials that count."""

from __future__ import annotations

import pandas as pd

from bench.plots import style
from bench.report.parts import Figure
from bench.topics.figures import ranks_along


def stability_figure(stability: pd.DataFrame, pens: style.Pens) -> Figure:
    """Return the mean rank of each optimizer over the number of trials that count, with the range over subsets."""
    caption = (
        "Stability of the ranks: the mean rank over problems with only the first trials of each cell, 1 for the best; "
        "bands are the range over random subsets of as many trials. All bands end in a point, where subsets hold all "
        "trials; a curve that still moves there needs more of them."
    )
    return ranks_along("stability", caption, stability, "trials", pens, stability)
