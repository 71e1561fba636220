"""The contribution of each optimizer to a portfolio, and how near sets of them come to the virtual best."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from bench.analysis.portfolio import NEAR
from bench.plots import style


def shapley_rows(members: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the Shapley value of each optimizer, with two standard errors where it is sampled.

    ``members`` are those of :func:`bench.analysis.portfolio_of`.
    """
    ax = style.own_axes(ax, height=style.rows_height(len(members)) + 0.5)
    at = range(len(members))
    ax.barh(at, 100 * members["shapley"], height=0.6, color=style.PALETTE[0])
    sampled = members["se"] > 0
    if sampled.any():
        ax.errorbar(100 * members["shapley"], at, xerr=200 * members["se"], fmt="none", ecolor="black", elinewidth=0.8)
    style.name_rows(ax, list(style.names(members["optimizer"]).values()))
    ax.axvline(0, color="black", linewidth=0.5)
    style.linear_scale(ax, "x")
    ax.set_xlabel("Shapley value, % of the targets")
    return ax


def set_sizes(sets: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the score of the best set of each size over that of the virtual best; dotted: 95 % of it.

    ``sets`` are those of :func:`bench.analysis.portfolio_of`.
    """
    ax = style.own_axes(ax)
    ax.axhline(NEAR, color="black", linewidth=0.6, linestyle=":")
    ax.plot(sets["size"], sets["ratio"], color=style.PALETTE[0], marker="o", markersize=4, linewidth=1.2)
    ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    style.linear_scale(ax, "y")
    ax.set_xlabel("optimizers in the set")
    ax.set_ylabel("over the virtual best")
    return ax
