"""The statistics: against scipy on random samples, and by hand on small ones."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ks_2samp, mannwhitneyu

from bench import analysis
from bench.objective import Trace
from bench.study import Entry, Study

INF = float("inf")


def frame_of(cells, **columns):
    """Build a tidy frame from {(problem, optimizer): values}; None stands for a failed trial."""
    rows = [
        {
            "problem": problem,
            "optimizer": optimizer,
            "trial": i,
            "status": "failed" if value is None else "ok",
            "fun": value,
        }
        for (problem, optimizer), values in cells.items()
        for i, value in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status", "fun"]).assign(**columns)


def one(table, **where):
    for column, value in where.items():
        table = table[table[column] == value]
    assert len(table) == 1
    return table.iloc[0]


class TestCells:
    def test_a_trial_that_failed_or_is_not_finite_scores_infinity(self):
        frame = frame_of({("p", "a"): [1.0, None, float("nan"), -INF, INF]})
        assert analysis.scores(frame).tolist() == [1.0, INF, INF, INF, INF]

    def test_summary_by_hand(self):
        row = one(analysis.summarise(frame_of({("p", "a"): [4.0, 1.0, 2.0, 3.0, 10.0]})))
        assert (row.n, row.failed, row["mean"], row["median"], row.q1, row.q3) == (5, 0, 4.0, 3.0, 2.0, 4.0)
        assert (row.best, row.worst) == (1.0, 10.0)
        assert row.sd == pytest.approx(np.sqrt((0 + 9 + 4 + 1 + 36) / 4))

    def test_a_failed_trial_leaves_no_mean_and_ranks_last(self):
        row = one(analysis.summarise(frame_of({("p", "a"): [1.0, 2.0, 3.0, None]})))
        assert (row.n, row.failed, row["median"], row.q1, row.q3) == (4, 1, 3.0, 2.0, INF)
        assert np.isnan(row["mean"])
        assert np.isnan(row.sd)
        assert (row.best, row.worst) == (1.0, INF)

    def test_one_trial_has_a_mean_but_no_sd(self):
        row = one(analysis.summarise(frame_of({("p", "a"): [2.0]})))
        assert row["mean"] == 2.0
        assert np.isnan(row.sd)

    def test_the_study_brings_its_order_and_its_empty_cells(self):
        study = Study("s", (Entry("q", "q"), Entry("p", "p")), (Entry("b", "b"), Entry("a", "a")), trials=3)
        frame = analysis.in_study_order(frame_of({("p", "a"): [1.0, 2.0], ("q", "b"): [1.0, None, 3.0]}), study)
        coverage = analysis.coverage(frame, planned=3)
        assert coverage[["problem", "optimizer"]].to_numpy().tolist() == [
            ["q", "b"],
            ["q", "a"],
            ["p", "b"],
            ["p", "a"],
        ]
        assert coverage["stored"].tolist() == [3, 0, 0, 2]
        assert coverage["failed"].tolist() == [1, 0, 0, 0]
        assert coverage["missing"].tolist() == [0, 3, 3, 1]

    def test_all_trials_failed(self):
        row = one(analysis.summarise(frame_of({("p", "a"): [None, None]})))
        assert (row.n, row.failed, row["median"]) == (2, 2, INF)


class TestPairs:
    @pytest.mark.parametrize("seed", range(5))
    def test_agrees_with_scipy_on_random_samples(self, seed):
        rng = np.random.default_rng(seed)
        samples = {("p", name): rng.normal(shift, 1, 30) for name, shift in zip("abcd", rng.random(4), strict=True)}
        pairs = analysis.pairwise_tests(frame_of(samples))
        assert len(pairs) == 6
        for pair in pairs.itertuples():
            this, other = samples["p", pair.first], samples["p", pair.second]
            expected = ks_2samp(this, other, method="exact")
            assert (pair.distance, pair.p) == (expected.statistic, expected.pvalue)
            assert pair.a12 == pytest.approx(mannwhitneyu(other, this).statistic / 900)
            assert pair.testable
            assert not pair.tied
        ordered = pairs.sort_values("p")
        by_hand = np.minimum(np.maximum.accumulate(ordered["p"].to_numpy() * np.arange(6, 0, -1)), 1)
        np.testing.assert_allclose(ordered["p_holm"], by_hand)
        assert (pairs["significant"] == (pairs["p_holm"] <= 0.05)).all()

    def test_complete_separation_by_hand(self):
        pair = one(analysis.pairwise_tests(frame_of({("p", "a"): [5, 6, 7, 8.0], ("p", "b"): [1, 2, 3, 4.0]})))
        assert (pair.distance, pair.a12, pair.lower) == (1.0, 0.0, "b")
        assert pair.p == pair.p_holm == pytest.approx(2 / 70)
        assert pair.significant

    def test_failed_trials_count_as_the_worst(self):
        pair = one(analysis.pairwise_tests(frame_of({("p", "a"): [1, 2, 3, 4.0], ("p", "b"): [None] * 4})))
        assert (pair.lower, pair.a12, pair.significant) == ("a", 1.0, True)

    def test_too_few_trials_are_untestable_and_say_so(self):
        pair = one(analysis.pairwise_tests(frame_of({("p", "a"): [1, 2, 3.0], ("p", "b"): [4, 5, 6.0]})))
        assert (pair.p, pair.p_holm, pair.testable, pair.significant) == (1.0, 1.0, False, False)
        assert pair.distance == 1.0

    def test_a_missing_cell_is_an_untestable_pair(self):
        frame = frame_of({("p", "a"): [1, 2, 3, 4.0], ("p", "b"): [5, 6, 7, 8.0], ("q", "a"): [1, 2, 3, 4.0]})
        pair = one(analysis.pairwise_tests(frame), problem="q")
        assert (pair.n_second, pair.p, pair.testable, pair.lower) == (0, 1.0, False, "")
        assert np.isnan(pair.distance)

    def test_identical_samples_differ_in_nothing(self):
        pair = one(analysis.pairwise_tests(frame_of({("p", "a"): [1.0] * 10, ("p", "b"): [1.0] * 10})))
        assert (pair.distance, pair.p, pair.a12, pair.lower, pair.tied) == (0.0, 1.0, 0.5, "", True)

    def test_one_optimizer_makes_no_pair(self):
        pairs = analysis.pairwise_tests(frame_of({("p", "a"): [1.0, 2.0]}))
        assert pairs.empty
        assert "p_holm" in pairs

    @pytest.mark.parametrize(
        ("values", "share"), [([1, 2, 3, 3.0], 0.5), ([1, 2.0], 0.0), ([], 0.0), ([INF, INF], 1.0)]
    )
    def test_tied_share(self, values, share):
        assert analysis.tied_share(np.array(values)) == share


class TestMatrixAndRanking:
    near, far = [1.05, 2.05, 3.05, 4.05, 5.05], [11.0, 12.0, 13.0, 14.0, 15.0]

    def test_bold_is_the_lowest_mean_and_italics_what_ks_cannot_tell_from_it(self):
        frame = frame_of({("p", "a"): [1, 2, 3, 4, 5.0], ("p", "b"): self.near, ("p", "c"): self.far})
        matrix = analysis.comparison_matrix(analysis.summarise(frame), analysis.pairwise_tests(frame))
        assert matrix.mean.loc["p"].tolist() == pytest.approx([3.0, 3.05, 13.0])
        assert matrix.best.loc["p"].tolist() == [True, False, False]
        assert matrix.alike.loc["p"].tolist() == [False, True, False]

    def test_alike_is_only_told_from_the_best_one(self):
        frame = frame_of({("p", "a"): self.far, ("p", "b"): [1, 2, 3, 4, 5.0], ("p", "c"): [v + 0.1 for v in self.far]})
        matrix = analysis.comparison_matrix(analysis.summarise(frame), analysis.pairwise_tests(frame))
        assert not matrix.alike.to_numpy().any()

    def test_a_cell_with_a_failure_has_no_mean_and_no_mark(self):
        frame = frame_of({("p", "a"): [1, 2, None], ("p", "b"): [3, 4, 5.0], ("p", "c"): [6, 7, 8.0]})
        matrix = analysis.comparison_matrix(analysis.summarise(frame), analysis.pairwise_tests(frame))
        assert matrix.best.loc["p"].tolist() == [False, True, False]
        assert matrix.alike.loc["p"].tolist() == [False, False, True]

    def test_nothing_is_best_of_one(self):
        frame = frame_of({("p", "a"): [1.0, 2.0]})
        matrix = analysis.comparison_matrix(analysis.summarise(frame), analysis.pairwise_tests(frame))
        assert not matrix.best.to_numpy().any()

    def test_ranking_counts_first_places_and_separable_ones(self):
        frame = frame_of(
            {
                ("p", "a"): [1, 2, 3, 4, 5.0], ("p", "b"): self.far,
                ("q", "a"): [1, 2, 3, 4, 5.0], ("q", "b"): self.near,
                ("r", "a"): self.far, ("r", "b"): self.near,
                ("s", "a"): self.far,
            }
        )  # fmt: skip
        ranking = analysis.ranking(analysis.summarise(frame), analysis.pairwise_tests(frame))
        assert ranking.to_dict("list") == {
            "optimizer": ["a", "b"], "problems": [3, 3], "first": [2, 1], "separable": [1, 1],
            "mean_rank": pytest.approx([4 / 3, 5 / 3]),
        }  # fmt: skip

    def test_ties_count_for_each_and_failures_for_none(self):
        frame = frame_of(
            {("p", "a"): [1, 1.0], ("p", "b"): [1, 1.0], ("q", "a"): [None, None], ("q", "b"): [None, None]}
        )
        ranking = analysis.ranking(analysis.summarise(frame), analysis.pairwise_tests(frame))
        assert ranking["first"].tolist() == [1, 1]
        assert ranking["separable"].tolist() == [0, 0]

    def test_one_optimizer_is_separable_from_nobody(self):
        frame = frame_of({("p", "a"): [1.0, 2.0]})
        ranking = analysis.ranking(analysis.summarise(frame), analysis.pairwise_tests(frame))
        assert ranking[["problems", "first", "separable"]].to_numpy().tolist() == [[1, 1, 0]]


class TestTiming:
    def test_by_hand(self):
        frame = frame_of({("p", "a"): [1, 1, None], ("p", "b"): [1, 1]})
        frame = frame.assign(
            wall_s=[1.0, 3.0, None, 2.0, 2.0],
            cpu_s=[1.0, 3.0, None, 1.0, 4.0],
            objective_s=[0.5, 1.5, None, 0, 0],
            nfev=300,
        )
        a = one(analysis.timing(frame), optimizer="a")
        assert (a.trials, a.wall_mean, a.wall_median, a.wall_q1, a.wall_q3) == (2, 2.0, 2.0, 1.5, 2.5)
        assert (a.objective_mean, a.objective_share, a.speed_median) == (1.0, 0.5, 200.0)
        assert (a.contention, a.hidden_threads) == (False, False)

    @pytest.mark.parametrize(("cpu", "flags"), [(0.8, (True, False)), (1.0, (False, False)), (1.2, (False, True))])
    def test_flags(self, cpu, flags):
        frame = frame_of({("p", "a"): [1.0, 1.0]}, wall_s=1.0, cpu_s=cpu, objective_s=0.1, nfev=10)
        row = one(analysis.timing(frame))
        assert (row.contention, row.hidden_threads) == flags

    def test_no_finished_trial_and_no_measurable_time(self):
        frame = frame_of({("p", "a"): [None], ("p", "b"): [1.0]}, wall_s=0.0, cpu_s=0.0, objective_s=0.0, nfev=1)
        assert analysis.timing(frame)["trials"].tolist() == [0, 1]


class TestAnytime:
    traces = (Trace(np.array([1, 10]), np.array([8.0, 2.0])), Trace(np.array([1, 100]), np.array([4.0, 0.0])))

    def test_grid_runs_from_one_to_the_budget(self):
        assert analysis.evaluation_grid(1).tolist() == [1]
        grid = analysis.evaluation_grid(60_000)
        assert (grid[0], grid[-1]) == (1, 60_000)
        assert (np.diff(grid) > 0).all()

    def test_median_by_hand(self):
        curve = analysis.best_so_far(self.traces, np.array([1, 10, 100]))
        assert curve["median"].tolist() == [6.0, 3.0, 1.0]
        assert curve["q1"].tolist() == [5.0, 2.5, 0.5]

    def test_failed_trials_count_as_infinite(self):
        curve = analysis.best_so_far(self.traces, np.array([1, 100]), failed=1)
        assert curve["median"].tolist() == [8.0, 2.0]
        assert curve["q3"].tolist() == [INF, INF]

    def test_an_empty_cell_has_no_curve(self):
        assert analysis.best_so_far([], np.array([1])).empty


class TestPower:
    def test_the_protocols_numbers(self):
        assert analysis.critical_distance(30, 0.05) == 11
        assert analysis.critical_distance(30, 0.005) == 14
        assert analysis.detectable_shift(30, 0.05) == pytest.approx(0.89, abs=0.03)
        assert analysis.detectable_shift(30, 0.005) == pytest.approx(1.19, abs=0.03)

    def test_three_trials_can_show_nothing(self):
        assert analysis.critical_distance(3, 0.05) is None
        assert analysis.detectable_shift(3, 0.05) is None
