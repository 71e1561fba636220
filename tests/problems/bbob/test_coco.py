"""What COCO's suites share: its functions, and its generator of random numbers."""

import cocoex
import numpy as np
import pytest

from problems.bbob.coco import bbob_function, evaluated, optimal_point, uniform
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


@pytest.mark.parametrize(("dimension", "instance"), [(2, 1), (5, 7), (40, 15), (5, 200_000)])
def test_optimal_points_are_coco_s(dimension, instance):
    theirs = cocoex.BareProblem("bbob", 10, dimension, instance).best_parameter()
    np.testing.assert_allclose(optimal_point(dimension, 10 + 10_000 * instance), theirs, rtol=0, atol=1e-12)


@pytest.mark.parametrize("one_call", [True, False])
def test_values_are_those_of_coco_for_any_array(one_call):
    theirs = function_of("bbob", 10, 3, 1)
    evaluate = bbob_function("bbob-f10-d3", 10, 3, 1) if one_call else evaluated(theirs)
    x = np.arange(12).reshape(4, 3) - 5
    expected = [theirs(row.astype(float)) for row in x]
    for given in (x.astype(float), np.asfortranarray(x, float), x.astype(float)[:, ::-1][:, ::-1]):
        np.testing.assert_array_equal(evaluate(given), expected)
    assert evaluate(np.empty((0, 3))).shape == (0,)
    for wrong in (np.zeros((2, 2)), np.zeros((2, 4)), np.zeros((2, 3, 3))):
        with pytest.raises(ValueError):
            evaluate(wrong)
