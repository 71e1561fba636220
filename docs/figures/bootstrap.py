"""A12 of many resamples of thirty runs of each optimizer, and the middle 95 % of them."""

import numpy as np
from matplotlib.figure import Figure

from bench.analysis.pairwise import a12, a12_replicates, percentile_interval


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(1)
    first, second = rng.normal(10, 2, 30), rng.normal(11, 2, 30)
    replicates = a12_replicates(first, second)
    figure = Figure()
    ax = figure.subplots()
    ax.hist(replicates, bins=50, alpha=0.8)
    low, high = percentile_interval(replicates)
    for each, line in ((low, "--"), (a12(first, second), "-"), (high, "--")):
        ax.axvline(each, color=ink, linestyle=line, linewidth=1)
        ax.text(each, 1.01, f"{each:.2f}", color=ink, ha="center", va="bottom", transform=ax.get_xaxis_transform())
    ax.set(xlabel="A12 of a resample; dashed: 95 % of them lie between", ylabel="resamples")
    return figure
