"""The share of targets reached over the evaluations, and the area that it encloses."""

import numpy as np
from matplotlib.figure import Figure


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    evaluations = np.geomspace(1, 10_000, 200)
    figure = Figure()
    ax = figure.subplots()
    for name, rate, start, end, line in (
        ("A: fast, then stuck", 1.6, 60, 0.7, "-"),
        ("B: slow, but goes on", 1.5, 700, 1, "--"),
    ):
        share = end / (1 + (start / evaluations) ** rate)
        (curve,) = ax.plot(evaluations, share, line, label=name)
        if line == "-":
            ax.fill_between(evaluations, share, alpha=0.2, color=curve.get_color())
    ax.set(xscale="log", xlabel="evaluations", ylabel="share of targets reached", ylim=(0, 1.02))
    ax.legend(loc="upper left", labelcolor=ink)
    return figure
