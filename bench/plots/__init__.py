"""Plots for notebooks and papers: each function draws one frame of :mod:`bench.analysis` on one matplotlib Axes.

Each function returns the Axes. Its parameters mean the same everywhere: ``problem`` is the label of the problem to
draw, ``pens`` the pen of each optimizer, by default by its place in the frame, ``legend`` whether to add one, and
``ax`` where to draw, by default new axes.

Example:
    >>> frame = bench.load_results("results/runs/thesis")
    >>> box_plot(frame, "signature-03")
    >>> with style.context():  # the look of a report: 8 pt text, for one column of a paper
    ...     timing(bench.analysis.timing(frame)).figure.savefig("timing.pdf")
"""

from inspect import isfunction

from bench.analysis.input import guarded
from bench.plots import style
from bench.plots.curves import convergence, ecdf, ert, spells
from bench.plots.forest import a12_forest
from bench.plots.rows import box_plot, strips, timing

__all__ = [
    "a12_forest",
    "box_plot",
    "convergence",
    "ecdf",
    "ert",
    "spells",
    "strips",
    "style",
    "timing",
]

for _name in __all__:
    if isfunction(globals()[_name]):
        globals()[_name] = guarded(globals()[_name])
