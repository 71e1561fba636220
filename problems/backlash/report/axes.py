"""Panels with the datasets on their x axis, and room for a legend above all panels."""

from __future__ import annotations

import re
from math import ceil

import matplotlib.figure
from matplotlib.axes import Axes

from bench.plots import style

LEFT, ACROSS = 0.45, 0.1  # inches
LABEL = 18  # characters of a dataset's name, such as "noisy-02 high"


def dataset_panels(
    titles: list[str], problems: list[str], entries: list[str], *, columns: int, height: float
) -> tuple[matplotlib.figure.Figure, list[Axes]]:
    """Return a figure as wide as the text and its titled axes, row by row, with the datasets at 0, 1, … of the x axis.

    Args:
        titles: a title for each panel; panels side by side share their y axis.
        problems: the labels of the datasets.
        entries: the texts of the legend above all panels (:func:`bench.plots.style.legend_above`), at most.
        columns: panels in a row.
        height: the height of a panel in inches.
    """
    names = [style.plain(short(problem), LABEL) for problem in problems]
    longest, digits = style.text_width(names), style.text_width(["00"])
    upright, columns = longest <= digits, min(columns, len(titles))
    figure, axes = style.grid(
        len(titles), columns=columns, height=height, left=LEFT, bottom=0.36 + (0 if upright else longest),
        top=0.25 + style.legend_height(entries), across=ACROSS, down=0.3,
    )  # fmt: skip
    width = (style.TEXT - LEFT) / columns - ACROSS
    every = ceil(len(names) * (longest + 0.06 if upright else 0.12) / width)
    for number, (ax, title) in enumerate(zip(axes, titles, strict=True)):
        if number:
            ax.sharex(axes[0])
        if number and columns > 1:
            ax.sharey(axes[0])
            ax.tick_params(axis="y", labelleft=number % columns == 0)
        ax.set_title(style.plain(title), loc="left")
        ax.grid(visible=False, axis="x")
        last = number >= len(axes) - columns
        ax.tick_params(axis="x", rotation=0 if upright else 90, labelbottom=last)
        if last:
            ax.set_xlabel("dataset")
    axes[0].set_xticks(range(0, len(names), every), names[::every])
    axes[0].set_xlim(-0.7, len(names) - 0.3)
    return figure, axes


def short(problem: str) -> str:
    """Return the number of a simulated or published dataset, any other label unchanged."""
    return re.sub(r"^(signature|published)-0*(?=\d+$)", "", problem)
