"""The problems on which optimizers are checked."""

import numpy as np
import pytest

from bench.check.bias import FLOOR
from bench.check.problems import FUNCTIONS, HALF_WIDTH, SHIFT, classic


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_its_optimum_where_it_is_said_to_be(name):
    for moved in (False, True):
        problem = classic(name, 5, moved=moved)
        place = SHIFT * 2 * HALF_WIDTH * moved
        assert problem.evaluate(np.full((1, 5), place))[0] == pytest.approx(0.0, abs=FLOOR)
        around = np.random.default_rng(0).uniform(-100, 100, (2000, 5))
        assert problem.evaluate(around).min() > 0
