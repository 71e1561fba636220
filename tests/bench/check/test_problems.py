"""The problems on which optimizers are checked."""

import numpy as np
import pytest

from bench.check import problems
from bench.check.bias import FLOOR
from bench.check.problems import FUNCTIONS, HALF_WIDTH, SHIFT, classic, noise


@pytest.mark.parametrize("dimension", [1, 2, 3, 50])
def test_the_bowl_s_optimum_is_inside_an_uneven_box(dimension):
    bowl = problems.bowl(dimension)
    best = bowl.lower + np.resize((0.3, 0.65, 0.8), dimension) * (bowl.upper - bowl.lower)
    assert bowl.evaluate(best[np.newaxis])[0] == pytest.approx(0.0, abs=1e-20)
    points = np.random.default_rng(0).uniform(bowl.lower, bowl.upper, (500, dimension))
    assert bowl.evaluate(points).min() > 0


def test_the_corner_is_the_optimum_of_a_narrow_box():
    corner = problems.corner()
    points = np.random.default_rng(0).uniform(corner.lower, corner.upper, (500, 3))
    best = np.array([[corner.lower[0], corner.upper[1], corner.lower[2]]])
    assert corner.evaluate(points).min() > corner.evaluate(best)[0]


def test_the_half_s_repair_moves_points_within_the_box():
    half = problems.half()
    repaired = half.repair(half.lower[np.newaxis])
    assert (repaired >= half.lower).all()
    assert repaired[0, 0] == (half.lower[0] + half.upper[0]) / 2


def test_odd_values_are_what_they_are_called():
    values = {}
    for name, problem in problems.odd().items():
        points = np.random.default_rng(0).uniform(problem.lower, problem.upper, (500, 3))
        values[name] = problem.evaluate(points)
    assert not values["equal values"].any()
    assert np.isposinf(values["+inf everywhere"]).all()
    some = values["+inf and NaN in half of the box"]
    assert 0.4 < np.isfinite(some).mean() < 0.6
    assert np.isnan(some).any()
    assert np.isposinf(some).any()
    assert values["values of 1e300"].max() > 1e299
    assert values["values of 1e-300"].max() < 1e-299
    assert values["negative values"].max() < 0


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_its_optimum_where_it_is_said_to_be(name):
    for moved in (False, True):
        problem = classic(name, 5, moved=moved)
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
    assert np.array_equal(values, np.random.default_rng(1).random(30))  # from the first on: no other call has drawn any
    assert not np.array_equal(noise((0.0, 1.0), 2, seed=2).evaluate(points), values)
