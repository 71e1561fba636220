"""Box plots and bars of times: what they draw, and what they say of the rest."""

import numpy as np

from bench import plots
from bench.plots import style
from tests.bench.plots.frames import axes, trials


def points_of(ax):
    """Return the values that have a point, of each row."""
    return [line.get_xdata().tolist() for line in ax.lines if line.get_marker() in style.MARKERS]


def test_boxes_are_quartiles_and_every_trial_is_a_point():
    values = np.array([1.0, 2.0, 3.0, 4.0, 100.0])
    ax = plots.box_plot(trials({("p", "a"): -values, ("q", "a"): [7.0]}), "p", ax=axes())
    (box,) = ax.patches
    assert {*box.get_path().vertices[:, 0]} == {-4.0, -2.0}
    (points,) = points_of(ax)
    assert sorted(points) == sorted(-values)
    *whiskers, median = (line.get_xdata().tolist() for line in ax.lines if line.get_marker() == "")
    assert whiskers == [[-4.0, -4.0], [-2.0, -1.0]]
    assert median == [-3.0, -3.0]
