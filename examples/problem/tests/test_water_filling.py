"""What an author's own tests need: that the problem is what it says, and that it is found by its name."""

import numpy as np
import pytest
from water_filling import SIZES

import bench
from bench.testing import parametrize_with_problem_checks

NAMES = [f"water-filling-{n}" for n in SIZES]


@parametrize_with_problem_checks(NAMES)
def test_conforms(check):
    """Every rule of 'bench check' is a case of its own."""
    check()


@pytest.fixture
def rng():
    return np.random.default_rng(1)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("total", [0.1, 1, 30])
def test_no_feasible_point_is_below_the_optimum_and_a_good_optimizer_reaches_it(name, total, rng):
    problem = bench.load_problem(name, total=total)
    points = problem.repair(rng.uniform(problem.lower, problem.upper, (2_000, problem.dimension)))
    assert (problem.evaluate(points) >= problem.optimum).all()
    best = bench.solve(problem, "cma-es", budget=20_000, seed=1).fun
    assert best == pytest.approx(problem.optimum, rel=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_repair_gives_the_nearest_feasible_point(name, rng):
    problem = bench.load_problem(name)
    x = rng.uniform(-1, 2, (500, problem.dimension))
    repaired = problem.repair(x)
    assert np.isfinite(problem.evaluate(repaired)).all()
    np.testing.assert_allclose(problem.repair(repaired), repaired, atol=1e-12)
    others = problem.repair(
        rng.uniform(-1, 2, x.shape)
    )  # the nearest point of a convex set lies in front of all others
    assert (((x - repaired) * (others - repaired)).sum(axis=1) < 1e-12).all()


def test_what_is_spent_beyond_the_total_is_worth_nothing():
    problem = bench.load_problem("water-filling-4", total=2)
    assert problem.evaluate(np.full((1, 4), 0.6)).tolist() == [np.inf]


def test_describe_gives_the_capacity_and_the_channels_in_use():
    problem = bench.load_problem("water-filling-4", total=0.1)  # noise 0.1, 0.4, 0.7 and 1
    assert problem.describe(np.array([0.1, 0.0, 0.0, 0.0])) == {"capacity_bits": 1.0, "channels": 1.0}


def test_wrong_options_are_one_sentence():
    with pytest.raises(bench.BenchError, match="must be a positive number, not -1"):
        bench.load_problem("water-filling-4", total=-1)
