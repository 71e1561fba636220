"""Which optimizer reaches targets fastest, by the seconds of an evaluation and the number of workers."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from bench.plots import style


def fastest_map(ranks: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the optimizer of the lowest mean rank for each number of workers and seconds of an evaluation.

    ``ranks`` are those of ``parallel_ranks``. Fields have the colour of the first optimizer, lighter
    where the second one is less than a rank behind, and its name stands once in those beside each other.
    """
    ax = style.own_axes(ax)
    wide = ranks.pivot_table(
        index=["workers", "seconds"], columns="optimizer", values="rank", sort=False, observed=True
    )
    workers, seconds = (sorted(wide.index.unique(level)) for level in ("workers", "seconds"))
    pens, field = style.pens(wide.columns, grey=False), style.inches(ax) / len(seconds)
    ordered = np.sort(wide.to_numpy(dtype=float), axis=1)
    leads = pd.Series(ordered[:, 1] - ordered[:, 0] if ordered.shape[1] > 1 else 1.0, wide.index)
    image = np.ones((len(workers), len(seconds), 3))
    for place, first, lead in zip(wide.index, wide.idxmin(axis=1), leads, strict=True):
        row, column = workers.index(place[0]), seconds.index(place[1])
        share = 0.15 + 0.4 * min(lead, 1.0)  # dark text can be read on it
        image[row, column] = 1 - share * (1 - np.array(to_rgba(pens[str(first)].color)[:3]))
    for row, each in enumerate(workers):
        firsts = wide.loc[each].reindex(seconds).dropna(how="all").idxmin(axis=1)
        for first, run in groupby(firsts.index, key=firsts.get):
            columns = [seconds.index(at) for at in run]
            name = style.plain(str(first), style.letters(len(columns) * field - 0.2, style.POINTS - 1))
            middle = (columns[0] + columns[-1]) / 2
            ax.text(middle, row, name, ha="center", va="center", color=style.DARK, fontsize=style.POINTS - 1)
    ax.pcolormesh(range(len(seconds)), range(len(workers)), image)
    ax.set_xticks(range(len(seconds)), [f"{value:g}" for value in seconds])
    ax.set_yticks(range(len(workers)), list(map(str, workers)))
    ax.set_xlabel("seconds of an evaluation")
    ax.set_ylabel("workers")
    ax.tick_params(length=0)
    ax.grid(visible=False)
    return ax
