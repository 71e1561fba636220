"""How often the test of direction finds a true A12, by its size and the number of trials."""

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from bench.analysis.direction import effects, p_values

REPEATS = 1_000


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(1)
    chances = np.linspace(0.5, 0.95, 10)
    figure = Figure()
    ax = figure.subplots()
    for n, line in ((10, ":"), (30, "-"), (100, "--")):
        ax.plot(chances, [found(n, chance, rng) for chance in chances], line, label=f"{n} trials each")
    ax.axhline(0.8, color=ink, linewidth=0.7, linestyle=":")
    ax.set(xlabel="true A12", ylabel="share that finds it", ylim=(0, 1.02))
    ax.legend(loc="lower right")
    return figure


def found(n: int, chance: float, rng: np.random.Generator) -> float:
    """Return the share of simulated pairs of normal samples with an A12 of ``chance`` that differ at 0.05."""
    first, second = rng.normal(0, 1, (2, REPEATS, n))
    return float((p_values(effects(first, second + np.sqrt(2) * norm.ppf(chance))) <= 0.05).mean())
