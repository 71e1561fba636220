"""The mean of values between 0 and 1: against Clopper and Pearson, random weights, and as rarely wrong as said."""

import numpy as np
import pytest
from scipy.stats import binomtest

from bench.analysis.bounded import intervals, p_of_at_most, p_values


@pytest.mark.parametrize(("n", "ones"), [(1, 1), (5, 5), (10, 7), (24, 20), (30, 3), (7, 0), (72, 40)])
@pytest.mark.parametrize("mean", [0.2, 0.5, 0.8])
def test_values_0_and_1_have_the_test_and_interval_of_a_proportion(n, ones, mean):
    values = np.append(np.ones(ones), np.zeros(n - ones))[:, np.newaxis]
    expected = binomtest(ones, n, mean, alternative="greater").pvalue
    assert p_of_at_most(values, np.array([mean]))[0] == pytest.approx(expected, rel=1e-9)
    exact = binomtest(ones, n).proportion_ci()
    assert np.ravel(intervals(values)) == pytest.approx([exact.low, exact.high], abs=1e-9)


def test_other_values_have_the_chance_of_their_random_weights():
    rng = np.random.default_rng(0)
    values = rng.random((12, 1)) * 0.6 + 0.3
    weights = rng.exponential(size=(200_000, 13))
    means = weights[:, :12] @ values[:, 0] / weights.sum(axis=1)
    assert p_of_at_most(values, np.array([0.5]))[0] == pytest.approx(np.mean(means <= 0.5), abs=0.005)


def test_pairs_are_tested_together_as_alone_and_from_either_side():
    values = np.random.default_rng(1).random((9, 5)).round(1)
    alone = [p_values(values[:, [place]])[0] for place in range(5)]
    assert p_values(values).tolist() == alone
    np.testing.assert_allclose(p_values(1 - values), alone, rtol=1e-9)
    low, high = intervals(values)
    np.testing.assert_allclose(intervals(1 - values), (1 - high, 1 - low), atol=1e-9)
    assert p_values(np.empty((0, 2))).tolist() == [1.0, 1.0]


@pytest.mark.parametrize("mean", [0.3, 0.5])
def test_the_interval_holds_a_mean_that_the_test_does_not_reject(mean):
    values = np.random.default_rng(2).random((8, 300)) ** 1.5
    low, high = intervals(values)
    np.testing.assert_array_equal((low <= mean) & (mean <= high), p_values(values, mean) > 0.05)


@pytest.mark.parametrize("n", [7, 29])
@pytest.mark.parametrize("skew", [(0.8, 0.6, 0.1), (0.9, 0.55, 0.05), (0.2, 0.9, 0.4)])
def test_skewed_values_are_wrong_no_more_often_than_the_level(n, skew):
    share, one, other = skew
    values = np.where(np.random.default_rng(n).random((n, 4_000)) < share, one, other)
    low, high = intervals(values)
    assert np.mean(p_values(values) <= 0.05) <= 0.06
    assert np.mean((low <= 0.5) & (high >= 0.5)) >= 0.94
