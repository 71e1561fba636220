"""Effect sizes over all problems, by hand, against scipy and as properties."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import bootstrap, trim_mean

from bench.analysis.aggregate import interquartile_mean, normalised_errors, probability_of_improvement
from bench.analysis.pairwise import a12

pytestmark = pytest.mark.filterwarnings("error")
INF = float("inf")


class TestImprovement:
    def test_by_hand(self, frame_of, one):
        frame = frame_of(
            {
                ("p", "a"): [1.0, 2.0], ("p", "b"): [3.0, 4.0],
                ("q", "a"): [1.0, 3.0], ("q", "b"): [2.0, 2.0],
                ("r", "a"): [1.0, 3.0],
            }
        )  # fmt: skip
        row = one(probability_of_improvement(frame))
        assert (row["first"], row.second, row.problems, row.probability) == ("a", "b", 2, 0.75)
        assert 0.5 <= row.low <= row.probability <= row.high <= 1  # on p, a is always ahead

    def test_the_interval_is_that_of_independent_problems(self, frame_of, one):
        rng = np.random.default_rng(2)
        samples = {(f"p{i}", name): rng.normal(shift, 1, 20) for i in range(4) for name, shift in (("a", 0), ("b", 1))}
        row = one(probability_of_improvement(frame_of(samples)))
        problems = [(samples[f"p{i}", "a"], samples[f"p{i}", "b"]) for i in range(4)]

        def mean_a12(*values, axis=-1):
            pairs = zip(values[::2], values[1::2], strict=True)
            return np.mean([(x[..., :, None] < y[..., None, :]).mean(axis=(-2, -1)) for x, y in pairs], axis=0)

        expected = bootstrap(
            [sample for pair in problems for sample in pair], mean_a12, n_resamples=9_999, batch=500,
            vectorized=True, method="percentile", random_state=np.random.default_rng(3),
        )  # fmt: skip
        assert row.probability == pytest.approx(np.mean([a12(*pair) for pair in problems]))
        assert row.low == pytest.approx(expected.confidence_interval.low, abs=0.005)
        assert row.high == pytest.approx(expected.confidence_interval.high, abs=0.005)

    @pytest.mark.parametrize("seed", range(2))
    def test_the_two_directions_add_up_to_one(self, random_frame, seed):
        frame = random_frame(seed)
        forth = probability_of_improvement(frame)
        frame["optimizer"] = pd.Categorical(frame["optimizer"], list("dcba"))
        back = probability_of_improvement(frame).set_index(["second", "first"])
        for row in forth.itertuples():
            mirrored = back.loc[(row.first, row.second)]
            assert row.probability + mirrored.probability == pytest.approx(1)
            assert (row.low, row.high) == pytest.approx((1 - mirrored.high, 1 - mirrored.low), abs=0.02)
        assert list(zip(forth["first"], forth["second"], strict=True)) == list(combinations("abcd", 2))

    def test_the_seed_decides(self, random_frame):
        frame = random_frame(0)
        pd.testing.assert_frame_equal(probability_of_improvement(frame), probability_of_improvement(frame))
        assert not probability_of_improvement(frame, seed=1).equals(probability_of_improvement(frame))

    def test_failures_are_the_worst_and_rounding_is_a_tie(self, frame_of, one):
        cells = {("p", "a"): [1.0, 1.0], ("p", "b"): [None, None], ("q", "a"): [1.0, 2], ("q", "b"): [1 + 1e-13, 2]}
        assert one(probability_of_improvement(frame_of(cells))).probability == 0.75

    def test_a_single_trial_leaves_no_interval(self, frame_of, one):
        row = one(probability_of_improvement(frame_of({("p", "a"): [1.0, 2.0], ("p", "b"): [3.0]})))
        assert row.probability == 1.0
        assert np.isnan([row.low, row.high]).all()

    def test_no_problem_with_every_optimizer(self, frame_of, one):
        row = one(probability_of_improvement(frame_of({("p", "a"): [1.0], ("q", "b"): [1.0]})))
        assert row.problems == 0
        assert np.isnan([row.probability, row.low, row.high]).all()

    def test_one_optimizer_and_an_empty_frame(self, frame_of):
        assert probability_of_improvement(frame_of({("p", "a"): [1.0]})).empty
        assert probability_of_improvement(frame_of({})).empty


class TestErrors:
    def errors(self, frame_of, values, optima=None):
        frame = frame_of({("p", "a"): values[::2], ("p", "b"): values[1::2]})
        errors = normalised_errors(frame, optima)
        assert list(errors.columns) == ["problem", "optimizer", "trial", "error"]
        order = np.argsort([*range(0, len(values), 2), *range(1, len(values), 2)])
        return errors["error"].to_numpy()[order].tolist()

    def test_the_lowest_is_zero_and_the_median_is_one(self, frame_of):
        assert self.errors(frame_of, [3, 5, 9, 4, 7]) == [0, 1, 3, 0.5, 2]

    def test_the_optimum_is_zero(self, frame_of):
        assert self.errors(frame_of, [3, 5, 9, 4, 7], {"p": 1.0, "q": 0.0}) == [0.5, 1, 2, 0.75, 1.5]

    def test_a_value_below_the_optimum_is_the_best_known(self, frame_of):
        assert self.errors(frame_of, [3, 5, 9, 4, 7], {"p": 3.5}) == [0, 1, 3, 0.5, 2]

    def test_the_largest_is_one_where_most_trials_found_the_best(self, frame_of):
        assert self.errors(frame_of, [2, 2, 2, 3, 6]) == [0, 0, 0, 0.25, 1]
        errors = self.errors(frame_of, [2 + 1e-13, 2, 2 - 1e-12, 3, 6], {"p": 2.0})
        assert errors[:3] == [0, 0, 0]  # which are not 1 by rounding
        assert errors[3:] == pytest.approx([0.25, 1])

    def test_the_largest_finite_one_is_one_where_most_trials_failed(self, frame_of):
        assert self.errors(frame_of, [2, None, None, 4, 6, None, None]) == [0, INF, INF, 0.5, 1, INF, INF]

    @pytest.mark.parametrize("optima", [None, {"p": 2.0}])
    def test_all_at_the_optimum_and_all_failed(self, frame_of, optima):
        assert self.errors(frame_of, [2, 2, 2], optima) == [0, 0, 0]
        assert self.errors(frame_of, [2, None, None], optima) == [0, INF, INF]
        assert self.errors(frame_of, [None, None], optima) == [INF, INF]

    def test_each_problem_has_its_own_scale(self, frame_of):
        frame = frame_of({("p", "a"): [1, 2, 3.0], ("q", "a"): [100, 300, 500.0]})
        assert normalised_errors(frame)["error"].tolist() == [0, 1, 2] * 2
        frame["problem"] = pd.Categorical(frame["problem"], ["r", "q", "p"])
        assert normalised_errors(frame)["error"].tolist() == [0, 1, 2] * 2


class TestInterquartileMean:
    def test_by_hand(self, frame_of, one):
        frame = frame_of({("p", "a"): [0, 1, 2, 3.0], ("p", "b"): [4, 5, 6, 7.0]})  # the median is 3.5
        table = interquartile_mean(frame)
        assert one(table, optimizer="a")[["problems", "n", "iqm"]].tolist() == pytest.approx([1, 4, 1.5 / 3.5])
        assert one(table, optimizer="b").iqm == pytest.approx(5.5 / 3.5)

    def test_against_scipy(self, frame_of):
        rng = np.random.default_rng(4)
        frame = frame_of({(f"p{i}", name): rng.gamma(2, 1, 11) for i in range(3) for name in "ab"})
        errors = normalised_errors(frame)
        for row in interquartile_mean(frame).itertuples():
            own = errors[errors["optimizer"] == row.optimizer]
            strata = [group.to_numpy() for _, group in own.groupby("problem")["error"]]
            expected = bootstrap(
                strata, lambda *samples: trim_mean(np.concatenate(samples), 0.25), vectorized=False,
                n_resamples=1_000, method="percentile", random_state=np.random.default_rng(5),
            )  # fmt: skip
            assert row.iqm == pytest.approx(trim_mean(own["error"], 0.25))
            assert row.low == pytest.approx(expected.confidence_interval.low, abs=0.04)
            assert row.high == pytest.approx(expected.confidence_interval.high, abs=0.04)

    def test_the_interval_covers_as_often_as_it_says(self, frame_of):
        rng = np.random.default_rng(6)
        covered = 0
        for _ in range(60):
            frame = frame_of({("p", "a"): rng.normal(10, 1, 40)})
            row = interquartile_mean(frame, {"p": 0.0}).iloc[0]
            scale = np.median(frame["fun"])  # a normal sample's interquartile mean estimates its mean
            covered += row.low <= 10 / scale <= row.high
        assert covered >= 50  # about 56 of 60

    @pytest.mark.parametrize(("failed", "finite"), [(2, True), (3, False)])
    def test_it_is_finite_while_at_most_a_quarter_failed(self, frame_of, one, failed, finite):
        values = [*np.arange(1.0, 9 - failed), *[None] * failed]
        row = one(interquartile_mean(frame_of({("p", "a"): values, ("p", "b"): np.arange(2.0, 10)})), optimizer="a")
        assert np.isfinite(row.iqm) == finite
        assert np.isfinite(row.low)
        assert row.high == INF

    def test_all_failed(self, frame_of):
        row = interquartile_mean(frame_of({("p", "a"): [None] * 4})).iloc[0]
        assert (row.iqm, row.low, row.high) == (INF, INF, INF)

    def test_all_at_the_optimum(self, frame_of):
        row = interquartile_mean(frame_of({("p", "a"): [2.0] * 4})).iloc[0]
        assert (row.iqm, row.low, row.high) == (0, 0, 0)

    def test_a_single_trial_leaves_no_interval(self, frame_of, one):
        frame = frame_of({("p", "a"): [1.0, 2.0], ("p", "b"): [3.0]})
        table = interquartile_mean(frame)
        assert one(table, optimizer="b").iqm == 2.0
        assert np.isnan([one(table, optimizer="b").low, one(table, optimizer="b").high]).all()
        assert one(table, optimizer="a").low <= one(table, optimizer="a").high

    def test_only_problems_with_every_optimizer_enter(self, frame_of, one):
        samples = {("p", "a"): [1.0, 2.0, 4.0], ("p", "b"): [3.0, 5.0, 2.0]}
        table = interquartile_mean(frame_of(samples))
        more = interquartile_mean(frame_of(samples | {("q", "a"): [9.0, 1.0]}))
        pd.testing.assert_frame_equal(table, more)
        assert table["n"].tolist() == [3, 3]

    def test_an_optimizer_without_trials_leaves_nothing_to_say(self, frame_of):
        frame = frame_of({("p", "a"): [1.0, 2.0]})
        frame["optimizer"] = pd.Categorical(frame["optimizer"], ["a", "b"])
        table = interquartile_mean(frame)
        assert table[["problems", "n"]].to_numpy().tolist() == [[0, 0], [0, 0]]
        assert table[["iqm", "low", "high"]].isna().all(axis=None)

    def test_an_empty_frame(self, frame_of):
        assert interquartile_mean(frame_of({})).empty

    @pytest.mark.parametrize("seed", range(2))
    def test_the_scale_of_a_problem_does_not_count(self, random_frame, seed):
        frame = random_frame(seed, problems=2)
        stretched = frame.assign(fun=frame["fun"].where(frame["problem"] != "p1", 1_000 * frame["fun"] + 7))
        pd.testing.assert_frame_equal(interquartile_mean(frame), interquartile_mean(stretched))
