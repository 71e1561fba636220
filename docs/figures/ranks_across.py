"""A critical-difference diagram of five optimizers on fifteen simulated problems."""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from bench import analysis, plots


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(4)
    strength = {"A": 0.0, "B": 0.2, "C": 0.9, "D": 1.1, "E": 2.5}
    medians = pd.DataFrame({name: each + rng.normal(0, 0.6, 15) for name, each in strength.items()})
    ranks = analysis.average_ranks(medians)
    figure = Figure(figsize=(6.4, 1.7))
    ax = figure.subplots()
    plots.cd_diagram(ranks, analysis.cliques(ranks, analysis.critical_difference(5, 15)), ax=ax)
    for each in ax.findobj(mpl.lines.Line2D):
        each.set_color(ink)
    for each in ax.findobj(mpl.text.Text):
        each.set_color(ink)
    return figure
