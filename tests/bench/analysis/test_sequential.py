"""Boundaries of group sequential tests, against published ones and against multivariate normal probabilities."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from bench.analysis.sequential import boundaries, levels, repeated_p, spent

EQUAL = [0.2, 0.4, 0.6, 0.8, 1.0]


def within(limits, shares, points=3_000_000):
    """The chance that |Z| stays within all limits, by scipy's integration of the multivariate normal."""
    t = np.array(shares)
    cov = np.sqrt(np.minimum.outer(t, t) / np.maximum.outer(t, t))
    limits = np.array(limits)
    law = type(multivariate_normal)(seed=1)  # a frozen one takes maxpts from scipy 1.16 on
    return law.cdf(limits, np.zeros(len(t)), cov, maxpts=points, abseps=1e-7, releps=1e-6, lower_limit=-limits)


def test_the_published_boundaries_of_lan_and_demets_for_five_equal_looks():
    # of the spending function of O'Brien and Fleming's kind, alpha = 0.05 on two sides
    np.testing.assert_allclose(boundaries(EQUAL, 0.05), [4.8769, 3.3569, 2.6803, 2.2898, 2.0310], atol=1.5e-4)


def test_the_judge_knows_the_published_boundaries_of_o_brien_and_fleming():
    assert within([4.5617, 3.2256, 2.6337, 2.2809, 2.0401], EQUAL, points=400_000) == pytest.approx(0.95, abs=2e-5)


@pytest.mark.parametrize("shares", [[1 / 6, 1 / 3, 1 / 2, 1.0], [0.5, 0.6, 1.0], [0.9, 0.95, 1.0]])
@pytest.mark.parametrize("alpha", [0.05, 0.005])
def test_what_is_spent_by_each_look_is_the_chance_to_have_crossed(shares, alpha):
    limits = boundaries(shares, alpha)
    for number in range(1, len(shares) + 1):
        crossed = 1 - within(limits[:number], shares[:number])
        assert crossed == pytest.approx(spent(alpha, shares[number - 1]), abs=5e-6)


def test_all_is_spent_at_the_end_and_one_look_is_an_ordinary_test():
    assert spent(0.05, 1.0) == pytest.approx(0.05)
    assert boundaries([1.0], 0.05) == pytest.approx([norm.isf(0.025)])
    assert sum(spent(0.05, share) > 0.01 for share in (0.1, 0.3, 0.5)) == 0


def test_many_close_looks_stay_exact():
    shares = [n / 60 for n in range(10, 61)]
    limits = boundaries(shares, 0.05)
    assert all(one > other for one, other in pairwise(limits))
    rng = np.random.default_rng(5)
    paths = rng.standard_normal((40_000, 60)).cumsum(axis=1)[:, 9:] / np.sqrt(np.arange(10, 61))
    assert np.mean((np.abs(paths) > limits).any(axis=1)) == pytest.approx(0.05, abs=0.0035)  # standard error 0.0011


@pytest.mark.parametrize("looks", [(10, 20, 30, 60), (4, 5), (20, 400)])
def test_a_repeated_p_value_is_the_level_at_which_the_look_rejects(looks):
    for place in range(len(looks)):
        for alpha in (0.2, 0.05, 0.0123, 1e-4):
            if (nominal := levels(looks, alpha)[place]) > 1e-290:
                assert repeated_p(nominal, looks, place) == pytest.approx(alpha, rel=2e-3)


def test_repeated_p_values_increase_with_p_and_are_never_smaller():
    p = np.concatenate((np.geomspace(1e-30, 0.1, 300), np.linspace(0.11, 1, 30)))
    for looks in ((10, 20, 30, 60), (5, 6, 7), (4, 4000), (4, 100_000)):
        for place in range(len(looks)):
            found = repeated_p(p, looks, place)
            assert (np.diff(found) >= 0).all()
            assert (found >= p).all()
            assert found[-1] == 1.0
    assert repeated_p([], (10, 20), 0).shape == (0,)


def test_the_last_of_the_looks_costs_little():
    assert repeated_p(0.04, (10, 20, 30, 60), 3) == pytest.approx(0.0407, abs=3e-4)
