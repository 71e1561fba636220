"""Pairs on one problem: against scipy and statsmodels on random samples, by hand on small ones, and as properties."""

from math import comb

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import bootstrap, false_discovery_control, ks_2samp, mannwhitneyu, norm, permutation_test
from statsmodels.stats.multitest import multipletests

from bench.analysis import pairwise
from bench.analysis.cells import cells
from bench.analysis.pairwise import (
    COLUMNS,
    RESAMPLES,
    a12,
    a12_replicates,
    bootstrap_intervals,
    compare_all,
    critical_distance,
    delong_intervals,
    detectable_shift,
    effect_size,
    holm,
    ks_distance,
    pairwise_tests,
    percentile_interval,
    permutation_p,
    power_table,
    tied_share,
)

pytestmark = pytest.mark.filterwarnings("error")
INF = float("inf")

whole_numbers = st.lists(st.integers(-40, 40) | st.none(), min_size=4, max_size=9)


def pair_of(frame_of, this, other, **options):
    pairs = pairwise_tests(frame_of({("p", "a"): this, ("p", "b"): other}), **options)
    assert len(pairs) == 1
    return pairs.iloc[0]


def distance_by_counting(this, other, axis):
    assert axis == -1
    shares = [(sample[..., np.newaxis] <= np.arange(10)).mean(axis=-2) for sample in (this, other)]
    return np.abs(shares[0] - shares[1]).max(axis=-1)


class TestAgainstLibraries:
    @pytest.mark.parametrize("seed", range(2))
    def test_untied_samples(self, frame_of, seed):
        rng = np.random.default_rng(seed)
        samples = {
            (problem, name): rng.normal(shift, 1, 30)
            for problem in "pq"
            for name, shift in zip("abcd", rng.random(4), strict=True)
        }
        pairs = pairwise_tests(frame_of(samples))
        assert len(pairs) == 12
        for pair in pairs.itertuples():
            this, other = samples[pair.problem, pair.first], samples[pair.problem, pair.second]
            expected = ks_2samp(this, other, method="exact")
            assert pair.distance == pytest.approx(expected.statistic)
            assert (pair.p, pair.method) == (expected.pvalue, "exact")
            assert pair.p_mw == mannwhitneyu(this, other, alternative="two-sided").pvalue
            assert pair.a12 == pytest.approx(mannwhitneyu(other, this).statistic / 900)
            assert pair.cliffs_delta == pytest.approx(2 * pair.a12 - 1)
            assert pair.testable
            assert not pair.tied
        for _, family in pairs.groupby("problem"):
            np.testing.assert_allclose(family["p_holm"], multipletests(family["p"], method="holm")[1])
        np.testing.assert_allclose(pairs["p_by"], multipletests(pairs["p"], method="fdr_by")[1])
        assert (pairs["significant"] == (pairs["p_holm"] <= 0.05)).all()
        assert (pairs["significant_by"] == (pairs["p_by"] <= 0.05)).all()

    @pytest.mark.parametrize("sizes", [(30, 30), (25, 12)])
    def test_tied_samples(self, frame_of, sizes):
        rng = np.random.default_rng(5)
        this, other = rng.integers(0, 6, sizes[0]), rng.integers(1, 7, sizes[1])
        pair = pair_of(frame_of, this, other)
        expected = permutation_test(
            (this, other), distance_by_counting, n_resamples=2_000, alternative="greater", axis=-1,
            random_state=np.random.default_rng(6),
        )  # fmt: skip
        assert (pair.method, pair.tied) == ("permutation", True)
        assert pair.distance == pytest.approx(expected.statistic)
        assert pair.p == pytest.approx(expected.pvalue, abs=0.03)  # three standard errors of 2,000 resamples
        assert pair.p < ks_2samp(this, other, method="exact").pvalue

    def test_few_tied_values_by_all_arrangements(self, frame_of):
        this, other = np.array([1, 1, 2, 2, 3.0]), np.array([2, 3, 3, 4, 4.0])
        every = permutation_test((this, other), distance_by_counting, axis=-1, alternative="greater")
        assert pair_of(frame_of, this, other).p == pytest.approx(every.pvalue, rel=1e-9)

    @pytest.mark.parametrize("k", [1, 2, 10, 45])
    def test_holm(self, k):
        p = np.random.default_rng(k).beta(0.2, 1, k).round(2)  # rounded: with ties, zeros and ones
        np.testing.assert_allclose(holm(p), multipletests(p, method="holm")[1])

    @pytest.mark.parametrize(("n", "m"), [(1, 2), (2, 2), (4, 7), (9, 3), (8, 8)])
    def test_distance(self, n, m):
        rng = np.random.default_rng(n + m)
        these, others = (rng.integers(0, 6, (8, size)).astype(float) for size in (n, m))
        these[these == 5], others[others == 5] = INF, INF
        expected = [ks_2samp(*pair, method="asymp").statistic for pair in zip(these, others, strict=True)]
        np.testing.assert_allclose(ks_distance(these, others), expected, atol=1e-15)

    def test_the_interval_of_a12(self, frame_of):
        rng = np.random.default_rng(8)
        this, other = rng.normal(0, 1, 30), rng.normal(0.6, 1, 20)
        pair = pair_of(frame_of, this, other)
        expected = bootstrap(
            (this, other), lambda x, y, axis=-1: (x[..., :, None] < y[..., None, :]).mean(axis=(-2, -1)),
            n_resamples=RESAMPLES, batch=500, vectorized=True, method="percentile",
            random_state=np.random.default_rng(9),
        )  # fmt: skip
        assert pair.a12_low == pytest.approx(expected.confidence_interval.low, abs=0.01)
        assert pair.a12_high == pytest.approx(expected.confidence_interval.high, abs=0.01)
        assert a12_replicates(this, other).std() == pytest.approx(expected.standard_error, rel=0.03)


class TestByHand:
    def test_columns(self, frame_of):
        frame = frame_of({("p", "a"): [1.0, 2.0], ("p", "b"): [3.0]})
        assert tuple(pairwise_tests(frame).columns) == COLUMNS

    def test_complete_separation(self, frame_of):
        pair = pair_of(frame_of, [5, 6, 7, 8.0], [1, 2, 3, 4.0])
        assert (pair.distance, pair.a12, pair.cliffs_delta, pair.lower) == (1.0, 0.0, -1.0, "b")
        assert (pair.separated, pair.a12_low, pair.a12_high) == (True, 0.0, 0.0)
        assert pair[["p", "p_holm", "p_by", "p_mw"]].tolist() == pytest.approx([2 / 70] * 4)
        assert pair.significant
        assert pair.significant_by

    def test_failed_trials_count_as_the_worst(self, frame_of):
        pair = pair_of(frame_of, [1, 2, 3, 4.0], [None] * 4)
        assert (pair.lower, pair.a12, pair.separated, pair.significant) == ("a", 1.0, True, True)

    def test_the_level_decides(self, frame_of):
        pair = pair_of(frame_of, [5, 6, 7, 8.0], [1, 2, 3, 4.0], alpha=0.03)
        assert (pair.significant, pair.testable) == (True, True)
        pair = pair_of(frame_of, [5, 6, 7, 8.0], [1, 2, 3, 4.0], alpha=0.02)
        assert (pair.significant, pair.testable, pair.method) == (False, False, "untestable")

    def test_too_few_trials_are_untestable_and_say_so(self, frame_of):
        pair = pair_of(frame_of, [1, 2, 3.0], [4, 5, 6.0])
        assert (pair.p, pair.p_holm, pair.p_by, pair.p_mw) == (1.0, 1.0, 1.0, 1.0)
        assert (pair.method, pair.testable, pair.significant, pair.significant_by) == ("untestable", *[False] * 3)
        assert (pair.distance, pair.a12) == (1.0, 1.0)

    def test_a_single_trial_has_no_interval(self, frame_of):
        pair = pair_of(frame_of, [1.0], [2.0, 3.0])
        assert pair.a12 == 1.0
        assert np.isnan(pair.a12_low)
        assert np.isnan(pair.a12_high)

    def test_a_missing_cell_is_an_untestable_pair(self, frame_of, one):
        frame = frame_of({("p", "a"): [1, 2, 3, 4.0], ("p", "b"): [5, 6, 7, 8.0], ("q", "a"): [1, 2, 3, 4.0]})
        pair = one(pairwise_tests(frame), problem="q")
        assert (pair.n_second, pair.p, pair.method, pair.lower) == (0, 1.0, "untestable", "")
        assert (pair.testable, pair.separated) == (False, False)
        assert np.isnan([pair.distance, pair.a12, pair.a12_low, pair.a12_high, pair.cliffs_delta]).all()

    @pytest.mark.parametrize("value", [1.0, None])
    def test_identical_samples_differ_in_nothing(self, frame_of, value):
        pair = pair_of(frame_of, [value] * 10, [value] * 10)
        assert (pair.distance, pair.p, pair.p_mw, pair.method) == (0.0, 1.0, 1.0, "identical")
        assert (pair.a12, pair.lower, pair.tied, pair.significant) == (0.5, "", True, False)

    def test_rounding_noise_at_one_optimum_is_not_tested(self, frame_of):
        rng = np.random.default_rng(0)
        this, other = 1 + 1e-14 * rng.integers(0, 20, 30), 1 + 1e-14 * rng.integers(20, 40, 30)
        assert ks_2samp(this, other, method="exact").pvalue < 1e-9
        pair = pair_of(frame_of, this, other)
        assert (pair.method, pair.p, pair.a12, pair.lower) == ("identical", 1.0, 0.5, "")

    def test_complete_separation_of_tied_values(self, frame_of):
        pair = pair_of(frame_of, [1, 1, 2] * 10, [4, 4, 5] * 10)
        assert (pair.tied, pair.method) == (True, "permutation")
        assert pair.p == pytest.approx(2 / comb(60, 30), rel=1e-9)

    @pytest.mark.parametrize(("n", "m"), [(30, 30), (7, 30), (1, 9), (12, 5)])
    def test_the_permutation_p_without_ties_is_the_exact_one(self, n, m):
        rng = np.random.default_rng(n + m)
        for shift in (0.0, 0.7, 3.0):
            this, other = rng.normal(size=n), rng.normal(shift, size=m)
            assert permutation_p(this[np.newaxis], other[np.newaxis])[0] == pytest.approx(
                ks_2samp(this, other, method="exact").pvalue, rel=1e-9
            )

    def test_a_difference_in_spread_alone_has_no_direction(self, frame_of):
        pair = pair_of(frame_of, np.linspace(-1, 1, 30), np.linspace(-10, 10.5, 30))
        assert (pair.significant, pair.lower) == (True, "")
        assert pair.a12_low < 0.5 < pair.a12_high

    def test_one_optimizer_and_an_empty_frame_make_no_pair(self, frame_of):
        for frame in (frame_of({("p", "a"): [1.0, 2.0]}), frame_of({})):
            pairs = pairwise_tests(frame)
            assert pairs.empty
            assert tuple(pairs.columns) == COLUMNS
            assert not pairs["significant"].any()

    def test_categories_bring_pairs_without_trials(self, frame_of):
        frame = frame_of({("p", "a"): [1, 2, 3, 4.0], ("p", "b"): [5, 6, 7, 8.0]})
        plain = pairwise_tests(frame)
        frame["optimizer"] = pd.Categorical(frame["optimizer"], ["b", "a", "c"])
        frame["problem"] = pd.Categorical(frame["problem"], ["q", "p"])
        pairs = pairwise_tests(frame)
        assert pairs[["problem", "first", "second"]].to_numpy().tolist() == [
            [problem, *pair] for problem in "qp" for pair in ("ba", "bc", "ac")
        ]
        assert pairs["p"].tolist() == [1.0, 1.0, 1.0, plain["p"].iloc[0], 1.0, 1.0]

    @pytest.mark.parametrize(
        ("values", "share"), [([1, 2, 3, 3.0], 0.5), ([1, 2.0], 0.0), ([], 0.0), ([INF, INF], 1.0)]
    )
    def test_tied_share(self, values, share):
        assert tied_share(np.array(values)) == share

    def test_a12_of_an_empty_sample(self):
        assert np.isnan(a12(np.empty(0), np.ones(3)))
        with pytest.raises(ValueError, match="empty"):
            a12_replicates(np.empty(0), np.ones(3))

    @pytest.mark.parametrize(
        ("value", "word"),
        [
            (0.5, "negligible"), (0.559, "negligible"), (0.56, "small"), (0.44, "small"), (0.63, "small"),
            (0.64, "medium"), (0.36, "medium"), (0.709, "medium"), (0.71, "large"), (0.29, "large"), (0.0, "large"),
            (1.0, "large"), (float("nan"), ""),
        ],
    )  # fmt: skip
    def test_effect_size(self, value, word):
        assert effect_size(value) == word

    def test_replicates_by_seed(self):
        this, other = np.arange(6.0), np.arange(6.0) + 1.5
        np.testing.assert_array_equal(a12_replicates(this, other, 3), a12_replicates(this, other, 3))
        assert not np.array_equal(a12_replicates(this, other, 3), a12_replicates(this, other, 4))
        assert not np.array_equal(a12_replicates(this, other, (0, 1)), a12_replicates(this, other, (0, 2)))
        # the two samples are drawn independently, also where they are of one size
        both = np.corrcoef(a12_replicates(this, np.full(6, 2.5)), a12_replicates(np.full(6, 2.5), this))
        assert abs(both[0, 1]) < 0.05

    def test_sums_in_float32_are_exact(self, monkeypatch):
        rng = np.random.default_rng(0)
        this, other = rng.integers(0, 9, (2, 40)).astype(float)
        fast = a12_replicates(this, other[:31], 7)
        monkeypatch.setattr("bench.analysis.pairwise.EXACT", 0)
        np.testing.assert_array_equal(fast, a12_replicates(this, other[:31], 7))

    def test_percentile_interval(self):
        assert percentile_interval(np.arange(101.0), 0.9) == pytest.approx((5.0, 95.0))
        assert percentile_interval(np.array([1.0, 2.0, INF])) == (2.0, INF)


class TestProperties:
    @given(st.lists(st.floats(0, 1), max_size=20))
    def test_holm_raises_p_and_keeps_the_order(self, p):
        p = np.array(p)
        adjusted = holm(p)
        assert ((p <= adjusted) & (adjusted <= 1)).all()
        assert (np.diff(adjusted[np.argsort(p, kind="stable")]) >= 0).all()

    @settings(max_examples=40)
    @given(whole_numbers, whole_numbers)
    def test_one_pair(self, frame_of, this, other):
        pair, mirrored = pair_of(frame_of, this, other), pair_of(frame_of, other, this)
        assert 0 < pair.p <= pair.p_holm <= 1
        assert pair.p <= pair.p_by <= 1
        assert pair.a12_low <= pair.a12_high
        assert pair.a12 + mirrored.a12 == pytest.approx(1)
        assert (pair.p_mw, pair.distance, pair.method) == (mirrored.p_mw, mirrored.distance, mirrored.method)
        assert pair.p == pytest.approx(mirrored.p, rel=1e-9)
        assert {pair.lower, mirrored.lower} in ({"a", "b"}, {""})

    @settings(max_examples=30)
    @given(whole_numbers, whole_numbers, st.sampled_from([lambda v: 3 * v - 7, lambda v: v**3, lambda v: 1.5**v]))
    def test_only_the_order_of_values_counts(self, frame_of, this, other, increasing):
        moved = [[None if v is None else increasing(v) for v in values] for values in (this, other)]
        pd.testing.assert_series_equal(pair_of(frame_of, this, other), pair_of(frame_of, *moved))

    @settings(max_examples=30)
    @given(whole_numbers, whole_numbers, st.integers(0, 8))
    def test_failing_is_never_better_than_any_value(self, frame_of, this, other, place):
        failed = [*this]
        failed[place % len(this)] = None
        assert pair_of(frame_of, failed, other).a12 <= pair_of(frame_of, this, other).a12

    @pytest.mark.parametrize("seed", range(3))
    def test_another_optimizer_changes_nothing_but_the_adjusted_p(self, random_frame, seed):
        frame = random_frame(seed)
        fewer = pairwise_tests(frame[frame["optimizer"] != "c"])
        pairs = pairwise_tests(frame)
        common = pairs[(pairs["first"] != "c") & (pairs["second"] != "c")].reset_index(drop=True)
        adjusted = ["p_holm", "p_by", "significant", "significant_by"]
        pd.testing.assert_frame_equal(
            common.drop(columns=adjusted), fewer.drop(columns=adjusted), check_categorical=False
        )
        assert (common["p_holm"] >= fewer["p_holm"]).all()

    def test_the_order_of_rows_changes_nothing_but_the_order_of_pairs(self, random_frame):
        frame = random_frame(0)
        pairs = pairwise_tests(frame)
        shuffled = pairwise_tests(frame.sample(frac=1, random_state=0)).set_index(["problem", "first", "second"])
        for pair in pairs.itertuples():
            names = (pair.first, pair.second)
            key = next(k for k in ((pair.problem, *names), (pair.problem, *names[::-1])) if k in shuffled.index)
            assert shuffled.loc[key, "p_mw"] == pytest.approx(pair.p_mw)
            assert shuffled.loc[key, "distance"] == pair.distance
            assert shuffled.loc[key, "lower"] == pair.lower

    def test_p_by_is_over_the_whole_frame(self, random_frame):
        pairs = pairwise_tests(random_frame(1))
        assert len(pairs) == 18
        np.testing.assert_allclose(pairs["p_by"], false_discovery_control(pairs["p"], method="by"))

    @pytest.mark.parametrize("seed", range(3))
    def test_a12_of_the_table_is_that_of_the_merged_cells(self, random_frame, seed):
        frame = random_frame(seed)
        found = cells(frame, merge=True)
        for pair in pairwise_tests(frame).itertuples():
            assert pair.a12 == a12(found[pair.problem, pair.first], found[pair.problem, pair.second])


class TestPower:
    def test_thirty_trials(self):
        assert critical_distance(30, 0.05) == 11
        assert critical_distance(30, 0.005) == 14
        assert detectable_shift(30, 0.05) == pytest.approx(0.89, abs=0.03)
        assert detectable_shift(30, 0.005) == pytest.approx(1.19, abs=0.03)

    def test_the_detectable_shift_has_the_power_it_says(self):
        rng = np.random.default_rng(4)
        shift = detectable_shift(12, 0.05)
        seen = [ks_2samp(*pair, method="exact").pvalue <= 0.05 for pair in rng.normal([[0], [shift]], 1, (400, 2, 12))]
        assert np.mean(seen) == pytest.approx(0.8, abs=0.06)  # three standard errors

    def test_three_trials_can_show_nothing(self):
        assert critical_distance(3, 0.05) is None
        assert detectable_shift(3, 0.05) is None

    def test_table(self):
        table = power_table(30, pairs=10)
        assert table["level"].tolist() == ["alpha", "first Holm step"]
        assert table["alpha"].tolist() == [0.05, 0.005]
        assert table["distance"].tolist() == [11, 14]
        assert table["shift"].tolist() == [detectable_shift(30, 0.05), detectable_shift(30, 0.005)]

    @pytest.mark.parametrize("n", [0, 1, 3])
    def test_table_of_too_few_trials_has_no_figures(self, n):
        assert power_table(n, pairs=10)[["distance", "shift"]].isna().all(axis=None)

    @pytest.mark.parametrize("pairs", [0, 1])
    def test_table_of_a_single_pair_has_no_holm_step(self, pairs):
        assert power_table(30, pairs)["level"].tolist() == ["alpha"]


class TestManyOptimizers:
    def test_the_interval_without_resampling_is_close_to_the_bootstrap(self):
        rng = np.random.default_rng(4)
        these, others = rng.standard_normal((40, 30)), rng.standard_normal((40, 25)) + rng.uniform(-1, 1, (40, 1))
        others[:5] = these[:5, :25]  # ties
        for one, other in zip(delong_intervals(these, others), bootstrap_intervals(these, others), strict=True):
            assert np.abs(one - other).max() < 0.04
            assert np.abs(one - other).mean() < 0.015

    def test_its_coverage(self):
        rng = np.random.default_rng(5)
        true = norm.cdf(0.8 / np.sqrt(2))  # of two normal distributions that lie 0.8 standard deviations apart
        low, high = delong_intervals(rng.standard_normal((4_000, 15)), rng.standard_normal((4_000, 15)) + 0.8)
        assert ((low <= true) & (true <= high)).mean() == pytest.approx(0.95, abs=0.02)

    def test_separated_samples_have_one_point(self):
        low, high = delong_intervals(np.array([[1.0, 2.0], [5.0, 6.0]]), np.array([[3.0, 4.0], [3.0, 4.0]]))
        assert low.tolist() == high.tolist() == [1.0, 0.0]

    def test_the_columns_do_not_depend_on_how_many_are_compared_at_once(self, monkeypatch):
        rng = np.random.default_rng(6)
        samples = [rng.integers(0, 9, rng.choice([9, 12])).astype(float) for _ in range(8)]
        whole = compare_all(samples)
        monkeypatch.setattr(pairwise, "AT_ONCE", 3)
        for name, values in compare_all(samples).items():
            assert np.array_equal(values, whole[name])
        assert not np.array_equal(whole["a12_low"], compare_all(samples, seed=1)["a12_low"])
        monkeypatch.setattr(pairwise, "RESAMPLED", 7)
        assert np.array_equal(compare_all(samples)["a12_low"], compare_all(samples, seed=1)["a12_low"])
