"""Runs that reach a target and runs that do not, and how restarts of them add up to a running time."""

import numpy as np
from matplotlib.figure import Figure

TIMES = np.array([300, 1_000, 450, 1_000, 1_000, 250, 700, 1_000])  # evaluations of eight runs; 1,000 is the budget


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    rng = np.random.default_rng(2)
    figure = Figure(figsize=(6.4, 3.0))
    runs, restarts = figure.subplots(1, 2, width_ratios=(2, 3))
    for row, time in enumerate(TIMES):
        reached = time < 1_000
        runs.barh(row, time, color="C0" if reached else "C1", hatch="" if reached else "///", height=0.7)
    runs.set(title="eight runs", xlabel="evaluations", yticks=[], ylim=(8, -1))
    for row in range(8):
        start = 0
        while True:
            time = int(rng.choice(TIMES))
            reached = time < 1_000
            colour, hatch = ("C0", "") if reached else ("C1", "///")
            restarts.barh(row, time, left=start, color=colour, hatch=hatch, height=0.7, edgecolor=ink, linewidth=0.4)
            start += time
            if reached:
                break
    ert = TIMES.sum() / (TIMES < 1_000).sum()
    restarts.axvline(ert, color=ink, linestyle="--", linewidth=1)
    restarts.text(ert, -1.1, f"ERT = {ert:,.0f}", color=ink, ha="center")
    restarts.set(xlabel="evaluations until the target, with restarts", yticks=[], ylim=(8, -1))
    return figure
