"""Ranks over the budget and forests."""

import numpy as np
import pandas as pd

from bench import plots
from bench.plots.ranks import legible, moved_apart
from tests.bench.plots.frames import axes, svg


class TestCourse:
    def test_names_of_close_ranks_stand_apart(self):
        """Two groups met where the first one was held below the least place: names of 35 optimizers overlapped."""
        places = {"a": 3.0, "b": 3.1, "c": 5.9, "d": 6.0, "e": 6.2, "f": 7.2, "g": 7.9, "h": 11.4}
        found = moved_apart(places, 2.0, 2.9)
        assert list(found) == list(places)
        assert np.diff(list(found.values())).min() >= 2.0 - 1e-9
        assert min(found.values()) == 2.9

    def test_names_that_are_apart_stay_at_their_ranks(self):
        assert moved_apart({"b": 4.0, "a": 1.0}, 1.5, 1.0) == {"a": 1.0, "b": 4.0}

    def test_ticks_that_would_touch_have_no_text(self):
        shares = [0.01, 0.03, 0.1, 0.3, 0.6, 1.0]
        texts = [f"{each:.0%}" for each in shares]
        assert legible(texts, shares, 1.9) == ["1%", "3%", "10%", "30%", "", "100%"]
        assert legible(texts, shares, 9.0) == texts
        assert legible(["5"], [5], 1.0) == ["5"]

    def test_a_line_leads_from_each_curve_to_its_name(self):
        ranks = pd.DataFrame({"optimizer": ["a", "a", "b", "b"], "share": [0.1, 1.0] * 2, "rank": [1.0, 1.5, 2.0, 1.5]})
        ax = plots.rank_course(ranks, ax=axes())
        leaders = {line.get_ydata()[1]: line.get_ydata()[0] for line in ax.lines[2:]}
        assert {text.get_position()[1] for text in ax.texts} == set(leaders)
        assert set(leaders.values()) == {1.5}


class TestForest:
    pairs = pd.DataFrame(
        {"problem": ["p", "p", "q"], "first": ["a", "a", "a"], "second": ["b", "c", "b"], "a12": [0.9, 0.45, 0.5],
         "joint_low": [0.8, 0.3, 0.4], "joint_high": [1.0, 0.6, 0.6], "significant": [True, False, False]}
    )  # fmt: skip

    def test_intervals_and_points(self):
        ax = plots.a12_forest(self.pairs, "p", ax=axes())
        assert [tick.get_text() for tick in ax.get_yticklabels()] == ["a vs b", "a vs c"]
        clear, open_ = ax.lines[-2:]
        assert (clear.get_xdata().tolist(), open_.get_xdata().tolist()) == ([0.9], [0.45])
        assert open_.get_markerfacecolor() == "white"
        np.testing.assert_allclose([s[:, 0] for s in ax.collections[-1].get_segments()], [[0.8, 1.0], [0.3, 0.6]])

    def test_a_missing_effect_keeps_its_row(self):
        pairs = self.pairs.assign(a12=np.nan, joint_low=np.nan, joint_high=np.nan)
        ax = plots.a12_forest(pairs, "p", ax=axes())
        svg(ax.figure)
        assert len(ax.get_yticklabels()) == 2
