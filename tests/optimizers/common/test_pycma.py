"""pycma's strategy with less work in Python: each shortcut returns what pycma returns, to the last bit."""

import copy

import numpy as np
import pytest
from cma.sampler import GaussFullSampler

from optimizers.common.pycma import Sampler, Strategy

SILENT = {"verbose": -9, "verb_log": 0, "seed": np.nan}


def learnt(dimension, number):
    """Return a sampler whose covariance is not diagonal, (n, d) vectors, and weights of both signs."""
    rng = np.random.default_rng(dimension)
    sampler = GaussFullSampler(10 ** rng.uniform(-1, 1, dimension))
    sampler.update(rng.standard_normal((3 * dimension, dimension)), np.full(3 * dimension, 0.2 / dimension))
    sampler.update_now(-1)
    return sampler, rng.standard_normal((number, dimension)), rng.uniform(-0.5, 1, number) / number


@pytest.mark.parametrize("number", [1, 2, 9, 301])
@pytest.mark.parametrize("dimension", [1, 2, 3, 4, 7, 8, 9, 12, 16, 20, 33, 50])
def test_an_update_is_pycma_s_to_the_last_bit(dimension, number):
    theirs, vectors, weights = learnt(dimension, number)
    ours = copy.deepcopy(theirs)
    ours.__class__ = Sampler
    for sampler in (theirs, ours):
        sampler.update(list(vectors), weights.tolist(), 0.01)
        sampler.update(vectors[::-1], np.abs(weights))  # no negative weight
        sampler.update(vectors, -0.01 * np.abs(weights))  # no positive one
        sampler.update_now(-1)
    np.testing.assert_array_equal(ours.C, theirs.C)
    np.testing.assert_array_equal(ours.B, theirs.B)
    assert ours.count_tell == theirs.count_tell


def test_vectors_that_overflow_are_an_error_as_in_pycma():
    for broken in (np.inf, np.nan, 1e200):
        theirs, vectors, _ = learnt(4, 5)
        theirs.__class__ = Sampler
        vectors[-1, 0] = broken
        with np.errstate(all="ignore"), pytest.raises(AssertionError):
            theirs.update(vectors, [0.5, 0.2, -0.1, -0.2, -0.2])


@pytest.mark.filterwarnings("ignore:.*timer")  # pycma's clock starts in its own ask
def test_injected_points_are_found_again():
    strategy = Strategy(np.zeros(3), 1.0, {**SILENT, "popsize": 8})
    strategy.inject([np.full(3, 0.1), np.full(3, 0.2)], force=True)
    points = strategy.ask()
    assert len(strategy._injected_solutions_archive) == 2
    assert strategy._clean_injected_solutions_archive(points) == [0, 1]
    strategy.tell(points, [float(sum(x**2)) for x in points], check_points=False)
    assert len(strategy._injected_solutions_archive) == 0


def test_a_point_to_repair_goes_pycma_s_way():
    strategy = Strategy(np.zeros(3), 1.0, SILENT)
    assert strategy.gp.geno(np.ones(3), repair=lambda x, copy_if_changed: -x).tolist() == [-1.0] * 3
