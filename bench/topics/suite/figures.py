"""Targets reached and running times on the functions of a suite."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import pandas as pd
from matplotlib.axes import Axes

from bench.analysis.cells import labels
from bench.plots import ecdf, ert_scatter, scaling, style
from bench.report.parts import Figure
from bench.topics.figures import (
    COLUMNS,
    at_round_numbers,
    beside_best,
    ended,
    legend_height,
    panels,
    span_times,
    titles,
)

ACROSS = 0.46  # inches between panels


def reached_figure(
    name: str,
    curves: pd.DataFrame,
    optimizers: Iterable[str],
    *,
    ends: Mapping[str, Mapping[str, float]] | None = None,
    what: str = "group",
    columns: int = COLUMNS,
) -> Figure:
    """Return the share of targets reached over evaluations / d, a panel a group of functions, or a function.

    ``curves`` are those of :func:`bench.analysis.ecdf` with a column problem, the panel's name, and may have the best
    of 2009; ``ends`` are the budgets by panel, where they are of simulated restarts.
    """
    pens = beside_best(curves, optimizers)
    above, down = titles(labels(curves, "problem"), columns, ACROSS)

    def draw(frame: pd.DataFrame, problem: str, *, pens: style.Pens, legend: bool, ax: Axes) -> Axes:
        ecdf(frame[frame["problem"] == problem], pens=pens, legend=legend, ax=ax, ends=(ends or {}).get(problem))
        ax.set_title(above[problem], loc="left", fontsize="small")
        ax.set_ylabel("share reached")
        return ax

    figure, _ = panels(curves, pens, draw, across=ACROSS, down=down, columns=columns)
    caption = (
        f"The share of all targets, of all problems and {'simulated restarts' if ends else 'trials'} of a {what}, "
        f"that was reached, over evaluations / d. Higher and further left is better.{ended(ends)}"
    )
    shown = at_round_numbers(curves, ["problem", "per_dimension"], "fraction", (1,))
    return Figure(name, caption, figure, curves, shown)


def scatter_figure(table: pd.DataFrame, across: str, up: str) -> Figure:
    """Return the ERT of one optimizer over that of another, a point a problem and target.

    ``table`` has problem, kind (such as the dimension), target and the two ERTs in evaluations / d, by optimizer.
    """
    kinds = list(dict.fromkeys(table["kind"]))
    pens = {kind: style.Pen(style.PALETTE[i % 8], style.MARKERS[i % 7], "") for i, kind in enumerate(kinds)}
    figure, (ax,) = style.grid(
        1,
        width=style.COLUMN,
        height=2.4,
        left=0.55,
        right=0.15,
        bottom=0.45,
        top=legend_height(pens, style.COLUMN) + 0.1,
    )
    ert_scatter(table, across, up, pens=pens, ax=ax)
    style.legend_above(figure, style.handles(pens))
    caption = (
        f"Expected running time / d of {up} over that of {across}, a point a problem and target. Above the diagonal, "
        f"{across} is faster. Dotted: infinite, as no trial reached the target."
    )
    return Figure("ert-scatter", caption, figure, table)


def scaling_figure(table: pd.DataFrame, optimizers: Iterable[str], *, target: str) -> Figure:
    """Return the expected running time to one target over the dimension, a panel a function.

    ``table`` has problem (the function), dimension, optimizer and ert, in evaluations / d.
    """
    figure, axes = panels(table, style.pens(optimizers), scaling, across=0.3)
    span_times(axes, table["ert"])
    caption = (
        f"Expected running time / d to {target}, over the dimension d. A horizontal line grows in "
        "proportion to d; a point is missing where no trial reached the target."
    )
    data = table.pivot(index=["problem", "dimension"], columns="optimizer", values="ert")
    return Figure("scaling", caption, figure, table, data[list(optimizers)].rename_axis(columns=None))
