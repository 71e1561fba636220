"""What COCO's suites share: its generator of random numbers."""

import ctypes
import gc
import sys
from types import SimpleNamespace

import cocoex
import numpy as np
import pytest

from bench import load_problem
from problems.bbob import coco
from problems.bbob.coco import evaluated, optimal_point, rotation, uniform
from tests.problems.bbob.best import function_of


def test_the_generator_repeats_its_published_start():
    """The first draw of seed 1 by hand: Park and Miller's numbers 9 to 40 fill the table, in reverse order."""
    state, numbers = 1, []
    for _ in range(41):
        state = 16807 * state % 2147483647  # the same generator without Schrage's trick
        numbers.append(state)
    table = numbers[39:7:-1]
    slot = table[0] // 67108865
    assert uniform(1, 1).tolist() == [table[slot] / 2147483647]


@pytest.mark.parametrize("seed", [0, 1, -1])
def test_seeds_below_one_count_as_their_absolute_value_or_one(seed):
    assert uniform(3, seed).tolist() == uniform(3, 1).tolist()


@pytest.mark.parametrize(("dimension", "instance"), [(2, 1), (5, 7), (40, 15), (5, 200_000)])
def test_optimal_points_are_coco_s(dimension, instance):
    theirs = cocoex.BareProblem("bbob", 10, dimension, instance).best_parameter()
    np.testing.assert_allclose(optimal_point(dimension, 10 + 10_000 * instance), theirs, rtol=0, atol=1e-12)


def test_a_rotation_is_orthonormal():
    matrix = rotation(7, 3)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(7), atol=1e-13)


DIMENSIONS = {"bbob": (2, 3, 5, 10, 20, 40), "bbob-boxed": (2, 10, 40), "bbob-largescale": (20, 80),
              "bbob-constrained": (2, 5, 20), "bbob-mixint": (5, 40)}  # fmt: skip
FUNCTIONS = {"bbob-constrained": 54}


@pytest.mark.parametrize(("suite", "dimension"), [(suite, d) for suite in DIMENSIONS for d in DIMENSIONS[suite]])
def test_the_compiled_loop_returns_the_bits_of_coco(suite, dimension):
    rng = np.random.default_rng(dimension)
    for number in range(1, FUNCTIONS.get(suite, 24) + 1):
        theirs = function_of(suite, number, dimension, int(rng.integers(1, 100)))
        x = rng.uniform(-6, 6, (8, dimension))  # some outside the box
        x[0] = np.nan
        np.testing.assert_array_equal(evaluated(theirs)(x), [theirs(row) for row in x])


@pytest.fixture(params=["without numba", "without exports", "compiled"])
def way(request, monkeypatch):
    """The ways of evaluating: as in a process that has not loaded numba, as on Windows, and as elsewhere."""
    coco._library.cache_clear()
    if request.param == "without numba":
        monkeypatch.delitem(sys.modules, "numba")
    if request.param == "without exports":
        monkeypatch.setattr(ctypes, "CDLL", lambda path: SimpleNamespace())
    yield request.param
    coco._library.cache_clear()


def test_every_way_takes_any_array_and_refuses_another_dimension(way):
    theirs = function_of("bbob", 10, 3, 1)
    evaluate = evaluated(theirs)
    x = np.arange(12).reshape(4, 3) - 5
    expected = [theirs(row.astype(float)) for row in x]
    for given in (x.astype(float), np.asfortranarray(x, float), x.astype(float)[:, ::-1][:, ::-1]):
        np.testing.assert_array_equal(evaluate(given), expected)
    assert evaluate(np.empty((0, 3))).shape == (0,)
    for wrong in (np.zeros((2, 2)), np.zeros((2, 4)), np.zeros((2, 3, 3))):
        with pytest.raises(ValueError):
            evaluate(wrong)


def test_numba_that_is_loaded_between_two_calls_changes_no_bit(monkeypatch):
    problem = load_problem("bbob-f21-d5-i3")
    x = np.random.default_rng(0).uniform(-5, 5, (9, 5))
    with monkeypatch.context() as without:
        without.delitem(sys.modules, "numba")
        before = problem.evaluate(x)
    np.testing.assert_array_equal(problem.evaluate(x), before)


def test_problems_that_are_dropped_are_freed(monkeypatch):
    freed = []
    library = coco._library()
    monkeypatch.setattr(library, "coco_problem_free", freed.append)
    evaluate = evaluated(function_of("bbob", 1, 2, 1))
    evaluate(np.zeros((1, 2)))
    assert freed == []
    del evaluate
    gc.collect()
    assert len(freed) == 1
