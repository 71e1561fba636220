"""Forests: intervals, points and rows."""

import numpy as np
import pandas as pd

from bench import plots
from tests.bench.plots.frames import axes


def test_intervals_and_points():
    rivals = pd.DataFrame(
        {"rival": ["b", "c"], "chance": [0.9, 0.45], "low": [0.8, 0.3], "high": [1.0, 0.6], "outcome": ["won", "open"]}
    )
    ax = plots.a12_forest(rivals, ax=axes())
    assert [tick.get_text() for tick in ax.get_yticklabels()] == ["b", "c"]
    clear, open_ = ax.lines[-2:]
    assert (clear.get_xdata().tolist(), open_.get_xdata().tolist()) == ([0.9], [0.45])
    assert open_.get_markerfacecolor() == "white"
    np.testing.assert_allclose([s[:, 0] for s in ax.collections[-1].get_segments()], [[0.8, 1.0], [0.3, 0.6]])
