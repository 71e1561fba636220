"""GWO and CMA-ES on a function whose optimum is in the centre of the box, and on the same function moved by a tenth."""

import numpy as np
from matplotlib.figure import Figure

import bench


def draw(ink: str) -> Figure:
    """Return the figure; ``ink`` is the colour of lines and letters."""
    figure = Figure()
    ax = figure.subplots()
    for row, name in enumerate(("gwo", "cma-es")):
        for offset, marker in ((0.0, "o"), (0.5, "s")):  # a tenth of the box is 0.5
            problem = bench.FunctionProblem(lambda x, c=offset: ((x - c) ** 2).sum(axis=1), [-2.5] * 5, [2.5] * 5)
            values = [bench.solve(problem, name, budget=1_500, seed=seed).fun for seed in range(15)]
            rows = row + (offset - 0.25) / 2 + np.linspace(-0.06, 0.06, 15)
            colour = "C0" if offset == 0 else "C1"
            where = "optimum moved" if offset else "optimum in the centre"
            ax.plot(
                np.maximum(values, 1e-60), rows, marker, color=colour, markersize=4, label=where if row == 0 else None
            )
    ax.set_yticks([0, 1], ["gwo", "cma-es"])
    ax.set(xscale="log", xlabel="final value of 15 runs of 1,500 evaluations on a sphere", ylim=(1.5, -0.5))
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.25), ncols=2, labelcolor=ink)
    return figure
