"""The scores of the configurations that a tuning tried, over the values of one parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.helpers.text import option
from bench.plots import style

LOOKS = {"": (style.PALETTE[0], "o", 10), "default": (style.PALETTE[1], "s", 26), "best": (style.PALETTE[4], "D", 26)}
"""Colour, marker and size of each kind of configuration."""


def sensitivity(table: pd.DataFrame, choices: Sequence[Any] = (), log: bool = False, *, ax: Axes | None = None) -> Axes:
    """Draw a point for each configuration: its score over its value of one parameter.

    Args:
        table: value, score and kind ("default", "best" or "") of each configuration; a value that is no number is left
            out unless it is a choice.
        choices: the values of a parameter that has few, in order.
        log: whether the values are drawn on a logarithmic axis.
        ax: where to draw.
    """
    ax = style.own_axes(ax)
    if choices:
        places = {option(choice): place for place, choice in enumerate(choices)}
        at = table["value"].map(option).map(places).astype(float) + style.spread(len(table))
        names = list(style.names(places, at_most=12).values())
        ax.set_xticks(range(len(places)), names)
        ax.set_xlim(-0.5, len(places) - 0.5)
    else:
        at = pd.to_numeric(table["value"], errors="coerce")
    for kind, (color, marker, size) in LOOKS.items():
        rows = table["kind"] == kind
        ax.scatter(
            at[rows], table["score"][rows], color=color, marker=marker, s=size, linewidths=0, zorder=2 + bool(kind)
        )
    if not choices and np.isfinite(at).any():
        (style.log_scale if log else style.linear_scale)(ax, "x")
    return ax
