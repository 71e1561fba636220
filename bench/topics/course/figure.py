"""The figure of the section: curves of targets reached with bands, and below them a strip of who is ahead."""

from __future__ import annotations

from math import ceil, floor, log10

import numpy as np
import pandas as pd

from bench.plots import ecdf, spells, style
from bench.plots.curves import AXES
from bench.report.parts import Figure
from bench.topics.course import live, words
from bench.topics.course.curves import ahead, compared, curves, rivals, span
from bench.topics.findings import Findings

SHOWN_ROWS = 60  # of the table behind the figure
ROW = 0.13  # inches, of a rival in the strip


def reached_figure(findings: Findings) -> Figure:
    """Return the curves of all that are shown; the strip is there where bands can be compared."""
    found, table, shown = findings.of(compared), findings.of(curves), findings.display.shown
    pens = {label: findings.display.pens[label] for label in shown}
    others = rivals(findings) if found.banded and len(findings.trials.optimizers) > 1 else []
    left = max(0.62, style.text_width(style.names(others).values(), style.SMALL) + 0.12)
    above = style.legend_height([str(entry.get_label()) for entry in style.handles(pens)]) + 0.1
    strip = ROW * len(others) + 0.06
    height = 2.3
    figure, axes = style.grid(
        1, height=height, left=left, bottom=0.36 + (strip + 0.2 if others else 0), top=above, columns=1
    )
    ecdf(table, pens=pens, legend=False, ax=axes[0])
    axes[0].set_xlim(*span(table, found.unit))
    style.log_scale(axes[0], "x")
    axes[0].set_ylim(
        -0.01, ceil(4 * float(table[[name for name in ("fraction", "high") if name in table]].max().max())) / 4
    )
    axes[0].yaxis.set_label_coords(-0.42 / style.inches(axes[0]), 0.5)
    style.legend_above(figure, style.handles(pens))
    if others:
        width, total = figure.get_size_inches()
        below = figure.add_axes((left / width, 0.06 / total, 1 - (left + 0.2) / width, strip / total))
        spells(findings.of(ahead), others, pens=findings.display.pens, ax=below)
        below.set_xscale("log")
        below.set_xlim(axes[0].get_xlim())
        below.tick_params(bottom=False, labelbottom=False, which="both")
        below.grid(visible=False)
    text = words.caption(findings.leader, AXES[found.unit], found.banded, len(shown), len(findings.trials.optimizers))
    return Figure(
        "targets-reached", text, figure, table, at_round_numbers(table, found.unit), live.targets_reached(findings)
    )


def at_round_numbers(table: pd.DataFrame, along: str) -> pd.DataFrame:
    """Return the fractions in a column an optimizer, at 1, 2 and 5 times powers of ten and at the end."""
    grid = np.unique(table[along].to_numpy(dtype=float))
    for factors in ((1, 2, 5), (1,)):
        marks = [factor * 10.0**power for power in range(floor(log10(grid[0])), ceil(log10(grid[-1])) + 1)
                 for factor in factors]  # fmt: skip
        inside = np.array([mark for mark in marks if grid[0] <= mark <= grid[-1]])
        at = np.unique([*grid[np.searchsorted(grid, inside * (1 + 1e-9), side="right") - 1], grid[-1]])
        if len(at) <= SHOWN_ROWS:
            break
    kept = table[table[along].isin(at)].astype({"optimizer": object})
    wide = kept.pivot(index=along, columns="optimizer", values="fraction")
    return wide[list(dict.fromkeys(kept["optimizer"]))].rename_axis(columns=None)
