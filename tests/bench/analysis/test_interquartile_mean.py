"""The interquartile mean with its bootstrap interval, against scipy and by hand."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import bootstrap, trim_mean

from bench.analysis.across import interquartile_mean, normalised_errors

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INF = float("inf")


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

    @pytest.mark.slow
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
