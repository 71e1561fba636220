"""Critical-difference diagrams and forests."""

import numpy as np
import pandas as pd

from bench import plots
from bench.plots.ranks import legible, moved_apart
from tests.bench.plots.frames import axes, ranks_of, svg, texts


class TestRanks:
    def test_names_stand_by_their_rank_and_bars_join_cliques(self):
        ranks = pd.Series({"worst": 4.0, "best": 1.25, "good": 2.0, "fair": 2.75})
        ax = plots.cd_diagram(ranks, [["best", "good"], ["good", "fair"], ["worst"]], 1.0, ax=axes())
        assert texts(ax)[:4] == ["best  1.25", "good  2.00", "4.00  worst", "2.75  fair"]
        assert "CD = 1.00" in texts(ax)
        bars = [bar.get_segments()[0][:, 0] for bar in ax.collections]
        np.testing.assert_allclose(bars, [[1.25, 2.0], [2.0, 2.75]], atol=0.05)
        elbows = [line.get_xdata()[0] for line in ax.lines[:4]]
        assert elbows == [1.25, 2.0, 4.0, 2.75]
        assert [line.get_xdata()[1] - line.get_xdata()[0] for line in ax.lines[4:]] == [1.0]

    def test_a_missing_rank_is_left_out(self):
        ax = plots.cd_diagram(pd.Series({"a": 1.0, "b": np.nan}), [["a", "b"]], ax=axes())
        assert texts(ax) == ["a  1.00"]
        assert not ax.collections

    def test_of_too_many_the_best_and_the_worst_are_named(self):
        ax = plots.cd_diagram(ranks_of([f"o{i}" for i in range(100)]), ax=axes())
        assert texts(ax)[0] == "o0  1.00"
        assert "100.00  o99" in texts(ax)
        assert "40 more between these" in texts(ax)


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
