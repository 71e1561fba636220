"""Cells: scores, summaries and near-ties, by hand and as properties."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom

from bench.analysis.cells import (
    ReferenceValue,
    cells,
    merge_near_ties,
    reference_values,
    regret,
    scores,
    stopped_early,
    summarise,
    timing,
)

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INF = float("inf")


class TestScoresAndCells:
    def test_a_trial_that_failed_or_is_not_finite_scores_infinity(self, frame_of):
        frame = frame_of({("p", "a"): [1.0, None, float("nan"), -INF, INF]})
        assert scores(frame).tolist() == [1.0, INF, INF, INF, INF]

    def test_near_ties_are_merged_over_the_cells_of_a_problem_and_not_over_problems(self, frame_of):
        near = 1 + 1e-13
        frame = frame_of({("p", "a"): [near, 2.0], ("p", "b"): [1.0, None], ("q", "a"): [near, 3.0]})
        merged = cells(frame, merge=True)
        assert merged["p", "a"].tolist() == [1.0, 2.0]
        assert merged["p", "b"].tolist() == [1.0, INF]
        assert merged["q", "a"].tolist() == [near, 3.0]
        assert cells(frame)["p", "a"].tolist() == [near, 2.0]
        assert scores(frame, merge=True).tolist() == [1.0, 2.0, 1.0, INF, near, 3.0]
        assert scores(frame).tolist() == [near, 2.0, 1.0, INF, near, 3.0]

    def test_only_a_finished_trial_that_declared_its_reason_stopped_early(self, frame_of):
        stops = ["budget", "undeclared", None, float("nan"), "tolx", "tolx"]
        frame = frame_of({("p", "a"): [1.0] * 5 + [None]}, stop=stops)
        assert stopped_early(frame).tolist() == [False] * 4 + [True, False]
        assert stopped_early(frame).dtype == bool
        assert not stopped_early(frame.iloc[:0]).any()


class TestSummary:
    def test_by_hand(self, frame_of, one):
        row = one(summarise(frame_of({("p", "a"): [4.0, 1.0, 2.0, 3.0, 10.0]})))
        assert (row.n, row.failed, row["mean"], row["median"], row.q1, row.q3) == (5, 0, 4.0, 3.0, 2.0, 4.0)
        assert (row.best, row.worst) == (1.0, 10.0)
        assert row.sd == pytest.approx(np.sqrt((0 + 9 + 4 + 1 + 36) / 4))

    def test_a_failed_trial_leaves_no_mean_and_ranks_last(self, frame_of, one):
        row = one(summarise(frame_of({("p", "a"): [1.0, 2.0, 3.0, None]})))
        assert (row.n, row.failed, row["median"], row.q1, row.q3) == (4, 1, 3.0, 2.0, INF)
        assert np.isnan(row["mean"])
        assert np.isnan(row.sd)
        assert (row.best, row.worst) == (1.0, INF)

    def test_the_interval_of_the_median_of_thirty_is_the_tenth_and_the_twenty_first(self, frame_of, one):
        values = np.random.default_rng(3).permutation(30) + 1.0
        row = one(summarise(frame_of({("p", "a"): values})))
        assert (row.median_low, row.median_high) == (10.0, 21.0)
        assert 1 - 2 * binom.cdf(9, 30, 0.5) >= 0.95 > 1 - 2 * binom.cdf(10, 30, 0.5)

    def test_failures_open_the_interval_upwards(self, frame_of, one):
        row = one(summarise(frame_of({("p", "a"): [*range(1, 21), *[None] * 10]})))
        assert (row.median_low, row.median_high) == (10.0, INF)


class TestReferences:
    @pytest.mark.parametrize(
        ("lowest", "optimum", "expected"),
        [
            (3.0, None, (3.0, False)),
            (3.0, 2.0, (2.0, True)),
            (3.0, 3.0, (3.0, True)),
            (3.0, 4.0, (3.0, False)),  # beaten, so it was none
            (3.0 - 1e-13, 3.0, (3.0, True)),  # by rounding
            (3.0 * (1 - 1.7e-10), 3.0, (3.0, True)),  # as a trial on signature-03, whose optimum was computed
            (3.0 - 1e-8, 3.0, (3.0 - 1e-8, False)),
            (-1e-300, 0.0, (-1e-300, False)),
            (INF, 2.0, (2.0, True)),
            (INF, None, (INF, False)),
            (3.0, float("nan"), (3.0, False)),
        ],
    )
    def test_the_optimum_unless_unknown_or_beaten(self, lowest, optimum, expected):
        optima = {"q": 0.0} if optimum is None else {"p": optimum, "q": 0.0}
        assert reference_values({"p": lowest}, optima) == {"p": ReferenceValue(*expected)}


class TestRegret:
    def test_by_hand(self):
        table = pd.DataFrame({"problem": ["p", "q", "r"], "median": [5.0, 1.0, 2.0], "q3": [INF, 3.0, 2.0], "n": 7})
        above = regret(table, {"p": 2.0, "r": -1.0}, ["median", "q3"])
        assert above["problem"].tolist() == ["p", "r"]
        assert above["median"].tolist() == [3.0, 3.0]
        assert above["q3"].tolist() == [INF, 3.0]
        assert above["n"].tolist() == [7, 7]

    @pytest.mark.parametrize(
        ("value", "optimum", "expected"),
        [
            (3.0 + 1e-11, 3.0, 0.0), (3.0 - 1e-11, 3.0, 0.0), (3.0 + 1e-9, 3.0, 1e-9), (-3.0 + 1e-11, -3.0, 0.0),
            (3.0 * (1 - 1.7e-10), 3.0, 0.0), (1e-300, 0.0, 1e-300),
            (0.0, 0.0, 0.0), (2.0, 3.0, -1.0), (float("nan"), 3.0, float("nan")),
        ],
    )  # fmt: skip
    def test_what_differs_by_rounding_is_at_the_optimum(self, value, optimum, expected):
        table = pd.DataFrame({"problem": pd.Categorical(["p"]), "best": [value]})
        assert regret(table, {"p": optimum}, ["best"])["best"].tolist() == pytest.approx(
            [expected], rel=1e-6, nan_ok=True
        )


class TestNearTies:
    def test_by_hand(self):
        values = np.array([2.0, 1 + 1e-13, 1.0, INF, 1 + 1e-9, -3.0, -3 - 1e-12, INF])
        assert merge_near_ties(values).tolist() == [2.0, 1.0, 1.0, INF, 1 + 1e-9, -3 - 1e-12, -3 - 1e-12, INF]


class TestTiming:
    def test_by_hand(self, frame_of, one):
        frame = frame_of({("p", "a"): [1, 1, None], ("p", "b"): [1, 1]}).assign(
            wall_s=[1.0, 3.0, None, 2.0, 2.0],
            cpu_s=[1.0, 3.0, None, 1.0, 4.0],
            objective_s=[0.5, 1.5, None, 0, 0],
            nfev=300,
        )
        a = one(timing(frame), optimizer="a")
        assert (a.trials, a.wall_mean, a.wall_median, a.wall_q1, a.wall_q3) == (2, 2.0, 2.0, 1.5, 2.5)
        assert (a.objective_mean, a.objective_share, a.speed_median) == (1.0, 0.5, 200.0)
        assert (a.contention, a.hidden_threads) == (False, False)
        assert np.isnan(a.per_call_median)
        more = one(timing(frame.assign(calls=[3, 6, None, 1, 1], memory_mb=[8.0, 2.0, None, 0, 1])), optimizer="a")
        assert (more.per_call_median, more.memory_most) == (75.0, 8.0)
