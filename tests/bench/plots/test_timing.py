"""Bars of the time of a trial."""

import numpy as np

from bench import plots
from tests.bench.plots.frames import axes, clock, texts


def test_bars_are_split_and_unknown_times_said():
    table = clock(["a", "b"])
    table.loc[1, ["trials", "wall_mean", "objective_mean"]] = [0, np.nan, np.nan]
    ax = plots.timing(table, ax=axes())
    assert [bar.get_width() for bar in ax.patches] == [0.5, 0.0, 1.5, 0.0]
    assert texts(ax) == ["2", "none finished"]
