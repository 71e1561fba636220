"""The problems on which optimizers are checked."""

import numpy as np
import pytest

from bench.check.conformance import problems


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
