"""Two optimizers whose runs end in two basins: the medians name one winner, the runs the other."""

import numpy as np
from matplotlib.figure import Figure

from bench.analysis.direction import a12


def samples() -> tuple[np.ndarray, np.ndarray]:
    """Return the final values of 30 runs of A and of B."""
    rng = np.random.default_rng(3)
    a = np.concatenate([rng.normal(1.0, 0.15, 14), rng.normal(5.0, 0.2, 16)])
    b = np.concatenate([rng.normal(4.0, 0.15, 16), rng.normal(6.0, 0.2, 14)])
    return a, b


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    a, b = samples()
    rng = np.random.default_rng(1)
    figure = Figure()
    ax = figure.subplots()
    for row, (values, marker) in enumerate(((a, "o"), (b, "s"))):
        ax.plot(values, row + rng.uniform(-0.18, 0.18, len(values)), marker, markersize=4, alpha=0.8)
        ax.plot([np.median(values)] * 2, [row - 0.32, row + 0.32], color=ink, linewidth=2)
        ax.text(np.median(values), row - 0.38, f"median {np.median(values):.1f}", color=ink, ha="center", va="bottom")
    ax.set_yticks([0, 1], ["A", "B"])
    ax.set(xlabel="final value of a run (lower is better)", ylim=(1.6, -0.75))
    ax.set_title(f"A12 = {a12(a, b):.2f}: the share of pairs in which the run of A is the lower one", fontsize=9)
    return figure
