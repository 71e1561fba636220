"""Draw the effects of a swept parameter's values, and the variance that each parameter and each pair explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import seaborn
from matplotlib.axes import Axes

from bench.plots import style

MANY = 60  # problems, of which each has a line


def main_effect(levels: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the mean chance of each value of one parameter, of :func:`bench.analysis.factors.contributions`.

    A thin line is a problem, the thick one their mean.
    """
    ax = style.own_axes(ax)
    table = levels.pivot(index="problem", columns="level", values="chance")[list(dict.fromkeys(levels["level"]))]
    at = np.arange(table.shape[1])
    if 1 < len(table) <= MANY:
        ax.plot(at, table.to_numpy(dtype=float).T, color=style.GREY, linewidth=0.6)
    ax.axhline(0.5, color="black", linewidth=0.5, linestyle=":")
    ax.plot(at, table.mean().to_numpy(dtype=float), color=style.PALETTE[0], marker="o", markersize=4, linewidth=1.6)
    ax.set_xticks(at, list(style.names(map(str, table.columns), at_most=14).values()))
    ax.set_xlim(-0.4, len(at) - 0.6)
    return ax


def share_map(shares: pd.Series[float], factors: Sequence[str], *, ax: Axes | None = None) -> Axes:
    """Draw the share of the variance of each parameter on the diagonal and of each pair of them below it."""
    ax = style.own_axes(ax)
    size = len(factors)
    grid = np.full((size, size), np.nan)
    for row, name in enumerate(factors):
        grid[row, row] = shares.get(name, np.nan)
        for column, other in enumerate(factors[:row]):
            grid[row, column] = shares.get(f"{other} × {name}", np.nan)
    names = list(style.names(factors, at_most=14).values())
    most = 1.6 * max(np.nan_to_num(grid).max(), 0.01)  # dark text can be read on every cell
    seaborn.heatmap(
        pd.DataFrame(grid, names, names), cmap="Blues", vmin=0, vmax=most, annot=True, fmt=".0%",
        annot_kws={"color": style.DARK}, cbar=False, ax=ax,
    )  # fmt: skip
    ax.tick_params(length=0, rotation=0)
    ax.grid(visible=False)
    return ax
