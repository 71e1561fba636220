"""How often at least one of many tests of equal optimizers raises a false alarm, with and without Holm's method."""

import numpy as np
from matplotlib.figure import Figure

from bench.analysis.pairwise import holm


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(1)
    numbers = np.array([1, 2, 3, 5, 10, 20, 50, 100])
    plain, adjusted = [], []
    for m in numbers:
        p = rng.uniform(size=(2_000, m))  # of equal optimizers, every p-value is as likely as any other
        plain.append((p.min(axis=1) <= 0.05).mean())
        adjusted.append(np.mean([holm(each).min() <= 0.05 for each in p]))
    figure = Figure()
    ax = figure.subplots()
    ax.plot(numbers, plain, "o-", label="each test at 0.05")
    ax.plot(numbers, adjusted, "s--", label="with Holm's method")
    ax.axhline(0.05, color=ink, linewidth=0.7, linestyle=":")
    ax.set(xscale="log", xlabel="number of tests", ylabel="chance of a false alarm", ylim=(0, 1.02))
    ax.set_xticks(numbers, [str(each) for each in numbers])
    ax.minorticks_off()
    ax.legend()
    return figure
