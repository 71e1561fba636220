"""Panels, margins and tables that the figures of several topics share."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Mapping
from math import ceil, floor, log10

import matplotlib.figure
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.analysis.cells import labels
from bench.plots import rank_course, style
from bench.plots.ranks import RANK_NAME
from bench.report.parts import Figure
from bench.topics.findings import BEST

SHOWN_ROWS = 300  # of the table behind a figure
COLUMNS = 3  # panels beside each other
LEFT, RIGHT = 0.6, 0.2  # inches beside them
LINE = 30  # letters of a title
MOST_ROWS = 40  # of a figure with a row for each optimizer: more could not all be named


def titles(names: Iterable[str], columns: int, across: float) -> tuple[dict[str, str], float]:
    """Return titles of at most 60 letters above :func:`panels`, in lines of small text that have room, by name.

    And the inches that the highest one needs. ``across`` is the space between panels.
    """
    width = style.PAGE if columns == COLUMNS else style.COLUMN
    room = style.letters((width - LEFT - RIGHT - (columns - 1) * across) / columns, style.SMALL)
    lines = {
        name: textwrap.wrap(style.plain(f"{name}", 60).replace(" = ", "\xa0=\xa0"), min(room, LINE)) for name in names
    }
    most = max(map(len, lines.values()), default=1)
    return {name: "\n".join(parts) for name, parts in lines.items()}, 0.16 + 0.12 * most


def panels(
    frame: pd.DataFrame,
    pens: style.Pens,
    draw: Callable[..., Axes],
    *,
    across: float,
    down: float = 0.3,
    columns: int = COLUMNS,
) -> tuple[matplotlib.figure.Figure, list[Axes]]:
    """Draw a panel for each problem that has rows, axis labels at the edges only, and the legend above all."""
    problems = [problem for problem in labels(frame, "problem") if (frame["problem"] == problem).any()]
    width, height = (style.PAGE, 1.0) if columns == COLUMNS else (style.COLUMN, 1.2)
    height = 0.85 if len(problems) > 6 * columns else height  # all rows on one page
    figure, axes = style.grid(
        len(problems), columns=columns, width=width, height=height, left=LEFT, right=RIGHT, across=across,
        down=down, top=legend_height(pens, width) + down - 0.05,
    )  # fmt: skip
    for place, (problem, ax) in enumerate(zip(problems, axes, strict=True)):
        draw(frame, problem, pens=pens, legend=False, ax=ax)
        if place % columns:
            ax.set_ylabel("")
        if place + columns < len(problems):
            ax.set_xlabel("")
            ax.tick_params(labelbottom=False)
    style.legend_above(figure, style.handles(pens))
    return figure, axes


def span_times(axes: Iterable[Axes], times: pd.Series[float]) -> None:
    """Give all axes the range of the finite running times, on a logarithmic scale."""
    finite = times.to_numpy(dtype=float)
    finite = finite[style.drawable(finite)]
    for ax in axes if len(finite) else ():
        ax.set_ylim(finite.min() / 2, 4 * finite.max())
        style.log_scale(ax, "y")


def left_margin(names: Iterable[str]) -> float:
    """Return the left margin in inches that the names of rows need."""
    return style.text_width(names, style.SMALL) + 0.12


def figure_width(margins: float) -> float:
    """Return the width of a column, or of the page where margins would leave less than two fifths of a column."""
    return style.COLUMN if margins < 0.6 * style.COLUMN else style.PAGE


def legend_height(pens: style.Pens, width: float | None = None) -> float:
    """Return the height in inches of a legend above panels of this width, or of the page's."""
    return style.legend_height([str(entry.get_label()) for entry in style.handles(pens)], width)


def at_round_numbers(frame: pd.DataFrame, rows: list[str], value: str, multiples: tuple[int, ...]) -> pd.DataFrame:
    """Return ``value`` in a column per optimizer, at round numbers of the last of ``rows`` and at its largest.

    Round numbers are 0 and the ``multiples`` of powers of ten, or the next value below each; there are fewer of them
    where the table would be longer than :data:`SHOWN_ROWS`.
    """
    *groups, along = rows
    grid = np.unique(frame[along].to_numpy(dtype=float))
    positive = grid[grid > 0]
    parts = len(frame[groups].drop_duplicates()) if groups else 1
    for factors in (multiples, (1,), ()):
        decades = range(floor(log10(positive[0])), ceil(log10(positive[-1])) + 1) if len(positive) else ()
        marks = np.array([factor * 10.0**decade for decade in decades for factor in factors])
        at = positive[np.searchsorted(positive, marks[marks >= positive[:1]] * (1 + 1e-9), side="right") - 1]
        at = np.intersect1d(grid, [0.0, *at, *grid[-1:]])
        if len(at) * parts <= SHOWN_ROWS:
            break
    kept = frame[frame[along].isin(at)].astype(dict.fromkeys((*groups, "optimizer"), object))
    table = kept.pivot(index=rows, columns="optimizer", values=value)
    order = pd.MultiIndex.from_frame(kept[rows].drop_duplicates()) if groups else pd.Index(at, name=along)
    optimizers = labels(frame, "optimizer")
    return table.reindex(index=order, columns=optimizers).rename_axis(columns=None)


def ranks_along(
    name: str, caption: str, ranks: pd.DataFrame, along: str, pens: style.Pens, data: pd.DataFrame
) -> Figure:
    """Return the figure of the mean ranks along a column of ``ranks``; ``data`` are what its file holds."""
    named = [label for label, pen in pens.items() if not pen.background]
    right = style.text_width(style.names(named, RANK_NAME).values()) + 0.3
    figure, (ax,) = style.grid(1, width=figure_width(right), height=1.9, left=0.45, right=right, bottom=0.4, top=0.08)
    rank_course(ranks, pens=pens, ax=ax)
    shown = ranks.pivot(index=along, columns="optimizer", values="rank")[list(pens)].rename_axis(columns=None)
    return Figure(name, caption, figure, data, shown)


def beside_best(curves: pd.DataFrame, optimizers: Iterable[str]) -> style.Pens:
    """Return the pens of the optimizers, and of the best of 2009 where there is a curve of it."""
    return dict(style.pens(optimizers)) | ({BEST: style.BESIDE} if (curves["optimizer"] == BEST).any() else {})


def ended(ends: Mapping[str, object] | None) -> str:
    """Return a sentence on the crosses of simulated restarts, "" where none are drawn."""
    return " Crosses: the end of the budget; beyond it, restarts are simulated." if ends else ""
