"""The Kolmogorov-Smirnov test of many pairs at once, against scipy, and by all arrangements where values are tied."""

import numpy as np
import pytest
from scipy.stats import ks_2samp, permutation_test

from bench.analysis.kolmogorov_smirnov import ks_distance, ks_tests, permutation_p

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INF = float("inf")


def ks_of(this, other):
    return {name: own[0] for name, own in ks_tests(*(np.array([x], dtype=float) for x in (this, other))).items()}


def distance_by_counting(this, other, axis):
    assert axis == -1
    shares = [(sample[..., np.newaxis] <= np.arange(10)).mean(axis=-2) for sample in (this, other)]
    return np.abs(shares[0] - shares[1]).max(axis=-1)


@pytest.mark.parametrize(("n", "m"), [(1, 2), (2, 2), (4, 7), (9, 3), (8, 8)])
def test_the_distance_is_scipy_s_also_of_tied_and_failed_trials(n, m):
    rng = np.random.default_rng(n + m)
    these, others = (rng.integers(0, 6, (8, size)).astype(float) for size in (n, m))
    these[these == 5], others[others == 5] = INF, INF
    expected = [ks_2samp(*pair, method="asymp").statistic for pair in zip(these, others, strict=True)]
    np.testing.assert_allclose(ks_distance(these, others), expected, atol=1e-15)


@pytest.mark.parametrize(("n", "m"), [(30, 30), (7, 30), (1, 9), (12, 5)])
def test_without_ties_p_is_the_exact_one(n, m):
    rng = np.random.default_rng(n + m)
    these, others = rng.normal(size=(9, n)), rng.normal(np.linspace(0, 3, 9)[:, np.newaxis], size=(9, m))
    found = ks_tests(these, others)
    expected = [ks_2samp(*pair, method="exact").pvalue for pair in zip(these, others, strict=True)]
    np.testing.assert_allclose(found["ks_p"], expected)
    np.testing.assert_allclose(permutation_p(these, others), expected, rtol=1e-9)
    assert not found["ks_tied"].any()


@pytest.mark.parametrize(("n", "m"), [(30, 30), (25, 12)])
def test_many_tied_values_by_random_arrangements(n, m):
    rng = np.random.default_rng(5)
    this, other = rng.integers(0, 6, n), rng.integers(1, 7, m)
    expected = permutation_test(
        (this, other), distance_by_counting, n_resamples=2_000, alternative="greater", axis=-1,
        random_state=np.random.default_rng(6),
    )  # fmt: skip
    found = ks_of(this, other)
    assert found["ks_distance"] == pytest.approx(expected.statistic)
    assert found["ks_p"] == pytest.approx(expected.pvalue, abs=0.03)  # three standard errors of 2,000 resamples
    assert found["ks_p"] < ks_2samp(this, other, method="exact").pvalue


def test_tied_pairs_that_share_an_outcome_have_the_p_that_each_has_alone():
    rng = np.random.default_rng(7)
    these, others = rng.integers(0, 3, (2, 40, 6)).astype(float)
    alone = [ks_of(*pair)["ks_p"] for pair in zip(these, others, strict=True)]
    np.testing.assert_allclose(ks_tests(these, others)["ks_p"], alone, rtol=1e-12)
    assert len(set(np.round(alone, 9))) > 5


def test_a_share_of_ten_percent_of_tied_values_is_not_tied():
    values = np.arange(20.0)
    values[1] = values[0]
    assert not ks_of(values[::2], values[1::2])["ks_tied"]
    values[2] = values[0]
    assert ks_of(values[::2], values[1::2])["ks_tied"]
