"""Intervals of A12 from forty repetitions of one comparison, and the true value."""

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from bench.analysis.direction import effects, intervals

TRUE = 0.65


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(1)
    first, second = rng.normal(0, 1, (2, 40, 30))
    found = effects(first, second + np.sqrt(2) * norm.ppf(TRUE))
    low, high = intervals(found)
    holds = (low <= TRUE) & (high >= TRUE)
    figure = Figure()
    ax = figure.subplots()
    ax.axhline(TRUE, color=ink, linewidth=1)
    ax.axhline(0.5, color=ink, linewidth=0.7, linestyle=":")
    for chosen, name, marker in ((holds, "holds the true value", "o"), (~holds, "misses it", "s")):
        at = np.flatnonzero(chosen)
        sides = (found.a12[chosen] - low[chosen], high[chosen] - found.a12[chosen])
        ax.errorbar(at, found.a12[chosen], sides, fmt=marker, markersize=3, linewidth=1, label=name)
    ax.set(xlabel="repetition of the comparison, thirty trials each", ylabel="A12", ylim=(0.25, 1))
    ax.set_xticks([])
    ax.legend(loc="upper right", ncols=2)
    return figure
