"""Plot curves: best-so-far values and shares of targets over evaluations, and running times over targets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator

from bench.plots import style

EVALUATIONS = "evaluations"
MOST_BANDS = 6  # optimizers up to which bands of quartiles can be distinguished
AXES = {"evaluations": EVALUATIONS, "per_dimension": "evaluations / d"}


def convergence(
    curves: pd.DataFrame, problem: str, *, pens: style.Pens | None = None, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Draw the median best-so-far value of each optimizer on a problem over evaluations, its quartiles as a band.

    ``curves`` are those of :func:`bench.analysis.convergence`. More than six optimizers have no bands. The axis of
    evaluations is logarithmic; so is that of the values where they are positive and span a factor of more than 3. A
    median or quartile that is infinite, because trials failed, is not drawn.
    """
    ax, pens = style.own_axes(ax), style.pens_of(curves, pens)
    rows = style.rows_of(curves, problem)
    _quartiles(ax, rows, pens)
    style.log_scale(ax, "x")
    style.fitting_scale(ax, "y", rows["median"], ratio=3)
    return _finish(ax, EVALUATIONS, "best value so far", pens if legend else None, problem)


def ecdf(
    curves: pd.DataFrame,
    *,
    pens: style.Pens | None = None,
    legend: bool = True,
    ax: Axes | None = None,
) -> Axes:
    """Draw the share of all targets that each optimizer reached, over evaluations (Hansen et al. 2022).

    ``curves`` are those of :func:`bench.analysis.ecdf`, or of ``bench.analysis.curve_bands``, whose bands are drawn.
    """
    return _fractions(curves, "share of targets reached", pens, legend, ax)


def spells(shown: pd.DataFrame, rivals: Sequence[str], *, pens: style.Pens, ax: Axes | None = None) -> Axes:
    """Draw when an optimizer or its rival is shown to be ahead: a row for each rival, a bar for each spell.

    A bar has the colour of who is ahead. ``shown`` are those of ``bench.analysis.spells``, with rivals as ``second``.
    """
    ax = style.own_axes(ax)
    for place, rival in enumerate(rivals):
        for spell in shown[shown["second"] == rival].to_dict("records"):
            ax.barh(place, spell["end"] - spell["begin"], 0.6, spell["begin"], color=pens[spell["ahead"]].color)
    ax.set_yticks(range(len(rivals)), list(style.names(rivals).values()))
    ax.set_ylim(len(rivals) - 0.5, -0.5)
    ax.tick_params(axis="y", length=0)
    return ax


def ert(
    table: pd.DataFrame, problem: str, *, pens: style.Pens | None = None, legend: bool = True, ax: Axes | None = None
) -> Axes:
    """Draw the expected running time of each optimizer on a problem over targets, harder ones to the right.

    ``table`` is that of :func:`bench.analysis.expected_running_time`. Both axes are logarithmic. A curve ends at the
    hardest target that any trial reached, in an open marker where no trial reached the harder ones. A log axis cannot
    show tau = 0: the axes of a problem whose trials start at its reference, which then has no other target, stay empty.
    """
    ax, pens = style.own_axes(ax), style.pens_of(table, pens)
    rows = style.rows_of(table, problem)
    rows = rows[rows["tau"] > 0].sort_values("tau", ascending=False, kind="stable")
    for place, (optimizer, pen) in enumerate(style.behind_first(pens)):
        tau, times = rows.loc[rows["optimizer"] == optimizer, ["tau", "ert"]].to_numpy(dtype=float).T
        reached = style.drawable(times)
        _curve(ax, tau[reached], times[reached], pen, place)
        if reached.any() and not reached.all():
            last = np.flatnonzero(reached)[-1]
            ax.plot(tau[last], times[last], pen.marker, color=pen.color, markersize=5.0, markerfacecolor="white")
    style.log_scale(ax, "x")
    style.log_scale(ax, "y")
    if len(rows):
        ax.set_xlim(rows["tau"].max() * 1.2, rows["tau"].min() / 1.2)
    return _finish(ax, "target tau", f"ERT in {EVALUATIONS}", pens if legend else None, problem)


def _quartiles(ax: Axes, curves: pd.DataFrame, pens: style.Pens) -> None:
    """Draw the medians and quartile bands of a problem, where an axis can show them."""
    drawn = curves[style.drawable(curves["median"])]
    for place, (optimizer, pen) in enumerate(style.behind_first(pens)):
        one = drawn[drawn["optimizer"] == optimizer]
        at, median, q1, q3 = one[["evaluations", "median", "q1", "q3"]].to_numpy(dtype=float).T
        banded = style.drawable(q3)
        if len(pens) <= MOST_BANDS:
            ax.fill_between(at[banded], q1[banded], q3[banded], color=pen.color, alpha=0.18, linewidth=0)
        _curve(ax, at, median, pen, place)


def _fractions(curves: pd.DataFrame, share: str, pens: style.Pens | None, legend: bool, ax: Axes | None) -> Axes:
    ax, pens = style.own_axes(ax), style.pens_of(curves, pens)
    along = next(name for name in AXES if name in curves)
    for place, (optimizer, pen) in enumerate(style.behind_first(pens)):
        one = curves[curves["optimizer"] == optimizer]
        x, fraction = one[[along, "fraction"]].to_numpy(dtype=float).T
        if "low" in one:
            low, high = one[["low", "high"]].to_numpy(dtype=float).T
            ax.fill_between(x, low, high, step="post", color=pen.color, alpha=0.18, linewidth=0)
        _curve(ax, x, fraction, pen, place, steps=True)
    style.span(ax, curves[along])
    style.log_scale(ax, "x")
    ax.set_ylim(-0.02, 1.02)
    ax.yaxis.set_major_locator(FixedLocator([0.0, 0.25, 0.5, 0.75, 1.0]))
    return _finish(ax, AXES[along], share, pens if legend else None)


def _curve(ax: Axes, x: np.ndarray, y: np.ndarray, pen: style.Pen, place: int, steps: bool = False) -> None:
    """Draw the curve of one optimizer with few markers, at other places than those of the previous optimizer."""
    every = max(len(x) // 5, 1)
    ax.plot(
        x, y, color=pen.color, linestyle=pen.line, linewidth=0.5 if pen.background else 1.1 * pen.width,
        marker=pen.marker, markersize=3.0,
        markevery=(2 * place % every, every), drawstyle="steps-post" if steps else "default",
    )  # fmt: skip


def _finish(ax: Axes, x: str, y: str, pens: style.Pens | None, problem: str = "") -> Axes:
    """Write the problem and the labels on the axes, with a legend at their right if there are ``pens``."""
    style.title(ax, problem)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    if pens is not None:
        ax.legend(handles=style.handles(pens), loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0)
    return ax
