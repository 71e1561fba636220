"""Two samples as steps of their distribution, and the largest distance between them."""

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import ks_2samp


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(1)
    first, second = np.sort(rng.normal(10, 2, 30)), np.sort(rng.normal(12, 2, 30))
    figure = Figure()
    ax = figure.subplots()
    for values, name, line in ((first, "optimizer A", "-"), (second, "optimizer B", "--")):
        ax.step(values, np.arange(1, 31) / 30, where="post", label=name, linestyle=line)
    test = ks_2samp(first, second, method="exact")
    at = test.statistic_location
    low, high = np.sort([(each <= at).mean() for each in (first, second)])
    ax.annotate("", (at, high), (at, low), arrowprops={"arrowstyle": "<->", "color": ink})
    ax.text(at + 0.15, (low + high) / 2, f"D = {test.statistic:.2f}", color=ink, va="center")
    ax.set(xlabel="final value of a run (lower is better)", ylabel="share of runs at or below", ylim=(0, 1.02))
    ax.legend(loc="lower right")
    return figure
