"""The figure of all runs: small panels on one grid, a dot a run."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.figure
import pandas as pd
from matplotlib.axes import Axes

from bench.plots import strips, style
from bench.report.parts import Figure, Table
from bench.topics.findings import Findings
from bench.topics.runs.marks import marks
from bench.topics.runs.panels import Panels, measured, panels
from bench.topics.runs.words import caption

COLUMNS = {1: 1, 2: 2, 3: 3, 4: 4, 5: 3, 6: 3, 7: 4, 8: 4}  # by the number of panels; more have six
ROW = 0.13  # inches, of an optimizer
BETWEEN = 0.24  # inches, of two panels


def runs_figure(findings: Findings, behind: Table) -> Figure:
    """Return the figure with the table that a reader opens below it."""
    shown, found = findings.display.shown, measured(findings)
    places = {title: problems for title, problems in panels(findings.trials).items() if problems}
    drawn = found.frame[found.frame["optimizer"].isin(shown)]
    figure, axes = _grid(places, shown)
    marked = marks(findings.final, places)
    values, columns = drawn["value"].dropna(), _columns(len(places))
    for place, ((title, problems), ax) in enumerate(zip(places.items(), axes, strict=True)):
        rows = drawn[drawn["problem"].isin(problems)]
        strips(rows, shown, {label: str(marked.at[title, label]) for label in shown}, pens=findings.display.pens, ax=ax)
        ax.set_xlim(*_limits(values, found.logarithmic))
        (style.log_scale if found.logarithmic else style.linear_scale)(ax, "x")
        below = place + columns >= len(places)
        ax.tick_params(labelleft=place % columns == 0, labelbottom=below)
        ax.set_xlabel("")
    for ax, name in zip(axes, _titles(places, axes[0]), strict=True):
        ax.set_title(name, loc="left", fontsize="small")
    axes[-1 - (len(places) - 1) % columns].set_xlabel(found.axis, loc="left")
    keys = ["problem", "optimizer", "trial", "status", "fun", "value"]
    text = caption(found.meaning, len(shown), len(findings.trials.optimizers), bool((marked != "").any(axis=None)))
    return Figure("every-run", text, figure, found.frame[keys], behind)


def _columns(number: int) -> int:
    return COLUMNS.get(number, 6)


def _grid(places: Panels, shown: Sequence[str]) -> tuple[matplotlib.figure.Figure, list[Axes]]:
    columns = _columns(len(places))
    left = style.text_width(style.names(shown).values(), style.SMALL) + 0.12
    return style.grid(
        len(places), columns=columns, height=ROW * len(shown) + 0.1, left=left, across=BETWEEN, down=BETWEEN,
        width=style.COLUMN if len(places) == 1 else style.PAGE,
    )  # fmt: skip


def _titles(places: Panels, ax: Axes) -> list[str]:
    """Return the titles of panels; long ones without a beginning up to a "-" that all share, such as a suite's name."""
    names, room = list(places), style.letters(style.inches(ax), style.SMALL)
    beginnings = {name.partition("-")[0] for name in names}
    if max(map(len, names)) > room and len(beginnings) == 1 and all("-" in name for name in names):
        names = [name.partition("-")[2] for name in names]
    return list(style.names(names, room).values())


def _limits(values: pd.Series[float], logarithmic: bool) -> tuple[float, float]:
    """Return the ends of the axis, a little beyond the least and the largest value."""
    values = values[style.drawable(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (1.0, 2.0)
    if logarithmic:
        return low / 1.6, high * 1.6
    room = 0.04 * max(high - low, 0.01 * abs(high), 1e-12)
    return low - room, high + room
