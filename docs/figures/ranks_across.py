"""A critical-difference diagram of five optimizers on fifteen simulated problems."""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from bench import analysis, plots


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(4)
    index = pd.MultiIndex.from_product([range(15), list("ABCDE"), range(10)], names=["problem", "optimizer", "trial"])
    frame = index.to_frame(index=False).assign(status="ok")
    shift = frame["optimizer"].map({"A": 0.0, "B": 0.2, "C": 0.9, "D": 1.1, "E": 2.5})
    frame = frame.assign(fun=shift + rng.normal(0, 1, len(frame)))
    pairs = analysis.pairwise_tests(frame)
    ranks = analysis.mean_ranks(analysis.standings(analysis.summarise(frame), pairs))
    figure = Figure(figsize=(6.4, 1.7))
    ax = figure.subplots()
    plots.cd_diagram(ranks, analysis.cliques(ranks, analysis.across_problems(pairs)), ax=ax)
    for each in ax.findobj(mpl.lines.Line2D):
        each.set_color(ink)
    for each in ax.findobj(mpl.text.Text):
        each.set_color(ink)
    return figure
