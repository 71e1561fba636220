"""Plots with a row per optimizer: box plots that also show every trial, dots, and bars of the mean wall time."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import seaborn
from matplotlib.axes import Axes
from numpy.typing import NDArray

from bench.analysis.cells import labels, scores
from bench.plots import style


def box_plot(frame: pd.DataFrame, problem: str, *, pens: style.Pens | None = None, ax: Axes | None = None) -> Axes:
    """Draw the objective values that the trials of each optimizer reached on a problem, in a row per optimizer.

    A row has a quartile box and a point per trial. Whiskers reach the furthest point within 1.5 box lengths (Tukey
    1977). The axis is logarithmic where the values are positive and wide. Trials without a finite value are counted at
    the right, not drawn. ``frame`` is the tidy frame (:func:`bench.load_results`).
    """
    optimizers = labels(frame, "optimizer")
    ax = style.own_axes(ax, height=style.rows_height(len(optimizers)) + 0.6)
    pens = style.pens_of(frame, pens)
    rows = style.rows_of(frame, problem)
    values = np.asarray(scores(rows), dtype=np.float64)
    by_row = [values[(rows["optimizer"] == optimizer).to_numpy()] for optimizer in optimizers]
    drawn = [row[style.drawable(row)] for row in by_row]
    _boxes(ax, drawn)
    _points(ax, drawn, [pens[optimizer] for optimizer in optimizers])
    for row, row_values in enumerate(by_row):
        ax.annotate(_note(row_values), (1.01, row), xycoords=ax.get_yaxis_transform(), va="center", fontsize="small")
    ax.use_sticky_edges = False  # the end of a bar is no limit of the axis
    style.fitting_scale(ax, "x", np.concatenate([*drawn, np.empty(0)]))
    style.name_rows(ax, list(style.names(optimizers).values()))
    ax.set_xlabel("objective value")
    style.title(ax, problem, 18)
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


def timing(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
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
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0)
    return ax


def _note(values: NDArray[np.float64]) -> str:
    """Return a note on the trials that a row does not show."""
    missing, huge = int((~np.isfinite(values)).sum()), int((np.isfinite(values) & ~style.drawable(values)).sum())
    notes = ([f"{missing} failed"] if missing else []) + ([f"{huge} too large"] if huge else [])
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
