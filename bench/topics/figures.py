"""Margins and widths that the figures of several sections share."""

from __future__ import annotations

from collections.abc import Iterable

from bench.plots import style

MOST_ROWS = 40  # of a figure with a row for each optimizer: more could not all be named


def left_margin(names: Iterable[str]) -> float:
    """Return the left margin in inches that the names of rows need."""
    return style.text_width(names, style.SMALL) + 0.12


def figure_width(margins: float) -> float:
    """Return the width of a column, or of the page where margins would leave less than two fifths of a column."""
    return style.COLUMN if margins < 0.6 * style.COLUMN else style.PAGE
