"""Plot best-so-far values, or their regret, over evaluations."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.plots import style

EVALUATIONS = "evaluations"


def convergence(
    curves: pd.DataFrame, problem: str, *, looks: style.Looks | None = None, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Draw the median best-so-far value of each optimizer on a problem over evaluations, its quartiles as a band.

    The axis of evaluations is logarithmic; so is that of the values where they are positive and span a factor of more
    than 3. A median or quartile that is infinite, because trials failed, is not drawn.

    Args:
        curves: columns problem, optimizer, evaluations, median, q1 and q3 (:func:`bench.analysis.convergence`).
        problem: the label of the problem to draw.
        looks: the look of each optimizer; by default by its place in ``curves``.
        legend: whether to name the optimizers beside the axes.
        ax: where to draw; by default new axes.
    """
    ax, looks = style.own_axes(ax), style.looks_of(curves, looks)
    own = style.rows_of(curves, problem)
    _quartiles(ax, own, looks)
    style.log_scale(ax, "x")
    style.fitting_scale(ax, "y", own["median"], ratio=3)
    return style.finish(ax, EVALUATIONS, "best value so far", looks if legend else None, problem)


def regret(
    curves: pd.DataFrame, problem: str, *, looks: style.Looks | None = None, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Draw the median regret of each optimizer on a problem over evaluations, its quartiles as a band, on log axes.

    A log axis cannot show a regret of 0: a curve ends where its median reaches the optimum, and where its lower
    quartile is at the optimum its band begins at the lowest value drawn.

    Args:
        curves: as for :func:`convergence`, less the optimum (:func:`bench.analysis.regret`).
        problem: the label of the problem to draw.
        looks: the look of each optimizer; by default by its place in ``curves``.
        legend: whether to name the optimizers beside the axes.
        ax: where to draw; by default new axes.
    """
    ax, looks = style.own_axes(ax), style.looks_of(curves, looks)
    own = style.rows_of(curves, problem)
    positive = own[own["median"] > 0]
    least = float(positive[["median", "q1"]].where(positive[["median", "q1"]] > 0).min().min())
    _quartiles(ax, positive.assign(q1=positive["q1"].clip(lower=least)), looks)
    style.log_scale(ax, "x")
    style.log_scale(ax, "y")
    return style.finish(ax, EVALUATIONS, "regret", looks if legend else None, problem)


def _quartiles(ax: Axes, own: pd.DataFrame, looks: style.Looks) -> None:
    """Draw the medians and quartile bands of a problem, where an axis can show them."""
    drawn = own[style.drawable(own["median"])]
    for place, (optimizer, look) in enumerate(looks.items()):
        one = drawn[drawn["optimizer"] == optimizer]
        at, median, q1, q3 = one[["evaluations", "median", "q1", "q3"]].to_numpy(dtype=float).T
        banded = style.drawable(q3)
        ax.fill_between(at[banded], q1[banded], q3[banded], color=look.color, alpha=0.18, linewidth=0)
        draw_curve(ax, at, median, look, place)


def draw_curve(ax: Axes, x: np.ndarray, y: np.ndarray, look: style.Look, place: int, steps: bool = False) -> None:
    """Draw the curve of one optimizer with few markers, at other places than those of the previous optimizer."""
    every = max(len(x) // 5, 1)
    ax.plot(
        x, y, color=look.color, linestyle=look.line, linewidth=1.1, marker=look.marker, markersize=3.0,
        markevery=(2 * place % every, every), drawstyle="steps-post" if steps else "default",
    )  # fmt: skip
