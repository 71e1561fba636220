"""How often the exact test finds a shift between two optimizers, by its size and the number of trials."""

import numpy as np
from matplotlib.figure import Figure

from bench.analysis.pairwise import critical_distance

REPEATS = 1_000


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(1)
    shifts = np.linspace(0, 2, 11)
    figure = Figure()
    ax = figure.subplots()
    for n, line in ((10, ":"), (30, "-"), (100, "--")):
        needed = critical_distance(n, 0.05)
        ax.plot(shifts, [found(n, shift, needed, rng) for shift in shifts], line, label=f"{n} trials each")
    ax.axhline(0.8, color=ink, linewidth=0.7, linestyle=":")
    ax.set(xlabel="shift, in standard deviations", ylabel="share that finds it", ylim=(0, 1.02))
    ax.legend(loc="lower right")
    return figure


def found(n: int, shift: float, needed: int, rng: np.random.Generator) -> float:
    """Return the share of simulated pairs of samples whose steps are ``needed`` / n apart somewhere."""
    values = np.concatenate([rng.normal(0, 1, (REPEATS, n)), rng.normal(shift, 1, (REPEATS, n))], axis=1)
    steps = np.where(np.argsort(values, axis=1) < n, 1, -1).cumsum(axis=1)
    return float((np.abs(steps).max(axis=1) >= needed).mean())
