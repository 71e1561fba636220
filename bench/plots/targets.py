"""Targets reached: empirical distributions of running times, data profiles and expected running times."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

from bench.plots import style
from bench.plots.convergence import EVALUATIONS, draw_curve

AXES = {"evaluations": EVALUATIONS, "groups": "groups of d + 1 evaluations"}


def ecdf(
    curves: pd.DataFrame, *, looks: style.Looks | None = None, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Draw the share of all targets that each optimizer reached, over evaluations (Hansen et al. 2022).

    Args:
        curves: columns optimizer, evaluations and fraction (:func:`bench.analysis.ecdf`).
        looks: the look of each optimizer; by default by its place in ``curves``.
        legend: whether to name the optimizers beside the axes.
        ax: where to draw; by default new axes.
    """
    return _fractions(curves, "evaluations", "share of targets reached", looks, legend, ax)


def data_profile(
    curves: pd.DataFrame, *, looks: style.Looks | None = None, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Draw the share of trials in which each optimizer reached a target, over evaluations (Moré and Wild 2009).

    Args:
        curves: columns optimizer, evaluations or groups (of d + 1 evaluations, "simplex gradients") and fraction
            (:func:`bench.analysis.data_profiles`).
        looks: the look of each optimizer; by default by its place in ``curves``.
        legend: whether to name the optimizers beside the axes.
        ax: where to draw; by default new axes.
    """
    along = "groups" if "groups" in curves else "evaluations"
    return _fractions(curves, along, "share of trials solved", looks, legend, ax)


def _fractions(
    curves: pd.DataFrame, along: str, share: str, looks: style.Looks | None, legend: bool, ax: Axes | None
) -> Axes:
    ax, looks = style.own_axes(ax), style.looks_of(curves, looks)
    for place, (optimizer, look) in enumerate(looks.items()):
        own = curves[curves["optimizer"] == optimizer]
        x, fraction = own[[along, "fraction"]].to_numpy(dtype=float).T
        draw_curve(ax, x, fraction, look, place, steps=True)
    style.span(ax, curves[along])
    style.log_scale(ax, "x")
    ax.set_ylim(-0.02, 1.02)
    ax.yaxis.set_major_locator(FixedLocator([0.0, 0.25, 0.5, 0.75, 1.0]))
    return style.finish(ax, AXES[along], share, looks if legend else None)


def ert(
    table: pd.DataFrame, problem: str, *, looks: style.Looks | None = None, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Draw the expected running time of each optimizer on a problem over targets, harder ones to the right.

    Both axes are logarithmic. A curve ends at the hardest target that any trial reached, in an open marker where no
    trial reached the harder ones. A log axis cannot show tau = 0: the axes of a problem whose trials start at its
    reference, which then has no other target, stay empty.

    Args:
        table: columns problem, optimizer, tau and ert, infinite where no trial reached the target
            (:func:`bench.analysis.expected_running_time`; Hansen et al. 2022).
        problem: the label of the problem to draw.
        looks: the look of each optimizer; by default by its place in ``table``.
        legend: whether to name the optimizers beside the axes.
        ax: where to draw; by default new axes.
    """
    ax, looks = style.own_axes(ax), style.looks_of(table, looks)
    own = style.rows_of(table, problem)
    own = own[own["tau"] > 0].sort_values("tau", ascending=False, kind="stable")
    for place, (optimizer, look) in enumerate(looks.items()):
        tau, times = own.loc[own["optimizer"] == optimizer, ["tau", "ert"]].to_numpy(dtype=float).T
        reached = style.drawable(times)
        draw_curve(ax, tau[reached], times[reached], look, place)
        if reached.any() and not reached.all():
            last = np.flatnonzero(reached)[-1]
            ax.plot(tau[last], times[last], look.marker, color=look.color, markersize=5.0, markerfacecolor="white")
    style.log_scale(ax, "x")
    style.log_scale(ax, "y")
    if len(own):
        ax.set_xlim(own["tau"].max() * 1.2, own["tau"].min() / 1.2)
    return style.finish(ax, "target tau", f"ERT in {EVALUATIONS}", looks if legend else None, problem)
