"""Plots with a row per optimizer: box plots that also show every trial, bars of the mean wall time, and of shares."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import seaborn
from matplotlib.axes import Axes
from matplotlib.ticker import PercentFormatter
from numpy.typing import NDArray

from bench.analysis.cells import labels, scores
from bench.plots import style

OBJECTIVE = "objective value"
PRECISION = "objective value less the optimum"


def box_plot(
    frame: pd.DataFrame, problem: str, *, column: str = "fun", expected: float | None = None,
    tolerance: float | None = None, optimum: float | None = None, least: float | None = None,
    pens: style.Pens | None = None, ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw the trials of each optimizer on a problem: a quartile box and a point per trial, in a row per optimizer.

    Whiskers reach the furthest point within 1.5 box lengths (Tukey 1977). The axis is logarithmic where the values
    are positive and wide. Trials without a finite value are counted at the right, not drawn.

    Args:
        frame: the tidy frame (:func:`bench.load_results`).
        column: "fun", the objective value, or the name of a domain metric.
        expected: the true value of the metric, drawn as a line.
        tolerance: the accepted distance from ``expected``, drawn as a band.
        optimum: the best known objective value, drawn as a line.
        least: the precision below which a problem is solved, where the objective values are precisions: lower values
            are drawn there, so that the axis can be logarithmic.
    """
    optimizers = labels(frame, "optimizer")
    ax = style.own_axes(ax, height=style.rows_height(len(optimizers)) + 0.6)
    pens = style.pens_of(frame, pens)
    rows = style.rows_of(frame, problem)
    values = _values(rows, column)
    if least is not None:
        values = np.maximum(values, least)
    by_row = [values[(rows["optimizer"] == optimizer).to_numpy()] for optimizer in optimizers]
    drawn = [row[style.drawable(row)] for row in by_row]
    _boxes(ax, drawn)
    _points(ax, drawn, [pens[optimizer] for optimizer in optimizers])
    for row, row_values in enumerate(by_row):
        note = _note(row_values, "failed" if column == "fun" else "missing")
        ax.annotate(note, (1.01, row), xycoords=ax.get_yaxis_transform(), va="center", fontsize="small")
    ax.use_sticky_edges = False  # the end of a bar is no limit of the axis
    shown = np.concatenate([*drawn, np.empty(0)])
    if least is None or least < shown.min(initial=np.inf) < np.inf:
        style.fitting_scale(ax, "x", shown)
    else:
        ax.set_xlim(least / 3, 3 * max(100 * least, shown.max(initial=least)))
        style.log_scale(ax, "x")
    if optimum is not None:
        _line(ax, optimum, "optimum")
    if expected is not None:
        _line(ax, expected, "expected")
    if expected is not None and tolerance is not None:
        ax.axvspan(
            expected - tolerance, expected + tolerance, facecolor="none", edgecolor=style.BAND, hatch="/////",
            linewidth=0.0, zorder=1, label=f"± {tolerance:.3g}",
        )  # fmt: skip
    style.name_rows(ax, list(style.names(optimizers).values()))
    ax.set_xlabel(style.plain(column) if column != "fun" else OBJECTIVE if least is None else PRECISION)
    style.title(ax, problem, 18)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(
            loc="lower right", bbox_to_anchor=(1.02, 0.99), borderaxespad=0.0, borderpad=0.2, ncols=2,
            handlelength=1.4, columnspacing=1.0,
        )  # fmt: skip
    return ax


def strips(
    rows: pd.DataFrame, optimizers: Sequence[str], marks: Mapping[str, str], *, pens: style.Pens, ax: Axes
) -> Axes:
    """Draw every run as a dot and the median of each optimizer as a line, in a row per optimizer.

    ``rows`` have optimizer, status and ``value``, missing for a failed run; failed ones are counted at the right, below
    the ``marks`` of the rows.
    """
    drawn = rows[style.drawable(rows["value"])].astype({"optimizer": object})
    colours = {label: pens[label].color for label in optimizers}
    seaborn.stripplot(
        drawn, x="value", y="optimizer", order=optimizers, hue="optimizer", hue_order=optimizers, palette=colours,
        jitter=False, size=2.2, alpha=0.7, legend=False, rasterized=len(drawn) > style.MANY_POINTS, ax=ax,
    )  # fmt: skip
    for dots in ax.collections:  # seaborn's own jitter comes from numpy's global generator
        places = np.asarray(dots.get_offsets())
        dots.set_offsets(np.column_stack([places[:, 0], places[:, 1] + style.spread(len(places))]))
    medians = drawn.groupby("optimizer")["value"].median()
    failed = rows.loc[rows["value"].isna(), "optimizer"].value_counts()
    for row, label in enumerate(optimizers):
        if label in medians:
            ax.plot(medians[label], row, "|", color="black", markersize=7, markeredgewidth=1.2, zorder=4)
        note = f"{marks.get(label, '')}{f' {failed[label]}✗' if failed.get(label, 0) else ''}"
        ax.annotate(note, (1.02, row), xycoords=ax.get_yaxis_transform(), va="center", fontsize="small")
    style.name_rows(ax, list(style.names(optimizers).values()))
    ax.set_ylabel("")
    return ax


def timing(table: pd.DataFrame, *, legend: bool = True, ax: Axes | None = None) -> Axes:
    """Draw the mean wall time of one trial of each optimizer, split into the objective and the rest.

    ``table`` is that of :func:`bench.analysis.timing`, in seconds. The row of an optimizer without a finished trial has
    a note instead.
    """
    ax = style.own_axes(ax, height=style.rows_height(len(table)) + 0.7)
    rows = np.arange(len(table))
    wall, objective = table[["wall_mean", "objective_mean"]].fillna(0.0).to_numpy(dtype=float).T
    parts = (("in the objective", 0.0 * wall, objective), ("in the optimizer", objective, wall - objective))
    for (name, start, width), color, hatch in zip(parts, style.PALETTE, style.HATCHES, strict=False):
        ax.barh(rows, width, left=start, height=0.62, color=color, hatch=hatch, edgecolor="white", label=name)
    for row in style.name_rows(ax, list(style.names(table["optimizer"]).values())):
        text = f"{wall[row]:.3g}" if table["trials"].iloc[row] else "none finished"
        ax.annotate(text, (wall[row], row), (3, 0), textcoords="offset points", va="center", fontsize="small")
    style.linear_scale(ax, "x")
    ax.margins(x=0.12)
    ax.set_xlim(left=0.0)
    ax.set_xlabel("mean wall time in s")
    if legend:
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)
    return ax


def shares(names: Sequence[str], values: Sequence[float], kinds: Sequence[int], best: float, *, ax: Axes) -> Axes:
    """Draw a bar for each row with a share from 0 to 1, and that of the best as a line.

    Args:
        names: of the rows.
        values: the shares, a row each.
        kinds: 0 or 1, a row each, which differ in colour and hatch.
        best: the share that the others are compared with.
        ax: where to draw.
    """
    for row, (value, kind) in enumerate(zip(values, kinds, strict=True)):
        ax.barh(row, value, height=0.62, color=style.PALETTE[kind], hatch=style.HATCHES[kind], edgecolor="white")
    for row in style.name_rows(ax, names):
        ax.annotate(f"{values[row]:.1%}", (1.02, row), xycoords=ax.get_yaxis_transform(), va="center", fontsize="small")
    ax.axvline(best, color="black", linewidth=1.0)
    ax.set_xlim(0.0, max(*values, best, 0.01) * 1.02)
    ax.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    ax.set_xlabel("targets reached")
    return ax


def _values(rows: pd.DataFrame, column: str) -> NDArray[np.float64]:
    if column == "fun":
        return np.asarray(scores(rows), dtype=np.float64)
    numbers = pd.to_numeric(rows[column], errors="coerce").where(rows["status"] == "ok", np.nan)
    return np.asarray(numbers, dtype=np.float64)


def _note(values: NDArray[np.float64], lost: str) -> str:
    """Return a note on the trials that a row does not show."""
    missing, huge = int((~np.isfinite(values)).sum()), int((np.isfinite(values) & ~style.drawable(values)).sum())
    notes = ([f"{missing} {lost}"] if missing else []) + ([f"{huge} too large"] if huge else [])
    return "\n".join(notes) if len(values) else "no trial"


def _boxes(ax: Axes, by_row: Sequence[NDArray[np.float64]]) -> None:
    """Draw a horizontal box a row, without outliers, as every value is a point."""
    thick = {"linewidth": 1.4}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "vert: bool")  # seaborn 0.13 uses this option, which matplotlib deprecates
        seaborn.boxplot(
            by_row, orient="h", width=0.62, color="white", saturation=1, linecolor="black", linewidth=0.7,
            medianprops=thick, showcaps=False, showfliers=False, ax=ax,
        )  # fmt: skip


def _points(ax: Axes, by_row: Sequence[NDArray[np.float64]], pens: Sequence[style.Pen]) -> None:
    """Draw every trial as a point.

    seaborn's stripplot has one marker for all rows, and takes jitter from numpy's global generator.
    """
    many = sum(map(len, by_row)) > style.MANY_POINTS
    for row, (values, pen) in enumerate(zip(by_row, pens, strict=True)):
        ax.plot(
            values, row + style.spread(len(values)), pen.marker, color=pen.color, markersize=2.5, markeredgewidth=0,
            alpha=0.7, zorder=3, rasterized=many,
        )  # fmt: skip


def _line(ax: Axes, value: float, name: str) -> None:
    """Draw a reference value, or only name it in the legend where a log axis cannot show it."""
    label = f"{name} {value:.4g}"
    if ax.get_xscale() == "log" and value <= 0:
        ax.plot([], [], color=style.REFERENCE, linewidth=1.0, label=f"{label} (off the axis)")
    else:
        ax.axvline(value, color=style.REFERENCE, linewidth=1.0, zorder=1.5, label=label)
