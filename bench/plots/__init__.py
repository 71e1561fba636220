"""Plots for notebooks and papers: each function draws one frame of :mod:`bench.analysis` on one matplotlib Axes.

Each function draws on ``ax``, or on new Axes without it, and returns the Axes.

Example:
    >>> frame = bench.load_results("results/runs/thesis")
    >>> box_plot(frame, "signature-03")
    >>> with style.context():  # the look of a report: 8 pt text, for one column of a paper
    ...     timing(bench.analysis.timing(frame)).figure.savefig("timing.pdf")
"""

from bench.plots import style
from bench.plots.convergence import convergence, regret
from bench.plots.distributions import box_plot
from bench.plots.ranks import a12_forest, cd_diagram
from bench.plots.targets import data_profile, ecdf, ert
from bench.plots.timing import timing

__all__ = [
    "a12_forest",
    "box_plot",
    "cd_diagram",
    "convergence",
    "data_profile",
    "ecdf",
    "ert",
    "regret",
    "style",
    "timing",
]
