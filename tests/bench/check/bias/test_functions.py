"""The functions and the noise."""

import numpy as np
import pytest

from bench.check.bias.diagnosis import FLOOR
from bench.check.bias.functions import FUNCTIONS, HALF_WIDTH, SHIFT, function, noise


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_its_optimum_where_it_is_said_to_be(name):
    for moved in (False, True):
        problem = function(name, 5, moved=moved)
        place = SHIFT * 2 * HALF_WIDTH * moved
        assert problem.evaluate(np.full((1, 5), place))[0] == pytest.approx(0.0, abs=FLOOR)
        around = np.random.default_rng(0).uniform(-100, 100, (2000, 5))
        assert problem.evaluate(around).min() > 0


def test_noise_depends_on_its_seed_and_the_number_of_evaluations_alone():
    points = np.random.default_rng(0).random((30, 2))
    values = noise((0.0, 1.0), 2, seed=1).evaluate(points)
    again = noise((0.0, 1.0), 2, seed=1)
    assert np.array_equal(np.concatenate([again.evaluate(points[:7] * 0), again.evaluate(points[7:])]), values)
    assert len(set(values)) == 30
    assert not np.array_equal(noise((0.0, 1.0), 2, seed=2).evaluate(points), values)
