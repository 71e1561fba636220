"""Best-so-far values over evaluations, as they are and as regret."""

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

    The evaluations have a log axis, and so have the values where they are positive and wide. A median or quartile
    that is infinite, because trials failed, is not drawn.

    Args:
        curves: columns problem, optimizer, evaluations, median, q1 and q3 (:func:`bench.analysis.convergence`).
        problem: whose curves.
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

    A curve ends where the median is at the optimum, which has no place on a log axis, and a band there goes on to the
    lowest value drawn.

    Args:
        curves: those of :func:`convergence`, counted from the optimum (:func:`bench.analysis.regret`).
        problem: whose curves.
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
    """Draw a problem's curves with their bands, as far as an axis can show them."""
    drawn = own[style.drawable(own["median"])]
    for place, (optimizer, look) in enumerate(looks.items()):
        one = drawn[drawn["optimizer"] == optimizer]
        at, median, q1, q3 = one[["evaluations", "median", "q1", "q3"]].to_numpy(dtype=float).T
        banded = style.drawable(q3)
        ax.fill_between(at[banded], q1[banded], q3[banded], color=look.color, alpha=0.18, linewidth=0)
        draw_curve(ax, at, median, look, place)


def draw_curve(ax: Axes, x: np.ndarray, y: np.ndarray, look: style.Look, place: int, steps: bool = False) -> None:
    """Draw one optimizer's curve with few markers, at other places than those of the optimizer before it."""
    every = max(len(x) // 5, 1)
    ax.plot(
        x, y, color=look.color, linestyle=look.line, linewidth=1.1, marker=look.marker, markersize=3.0,
        markevery=(2 * place % every, every), drawstyle="steps-post" if steps else "default",
    )  # fmt: skip
