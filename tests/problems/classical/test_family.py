"""The family classical: names, instances, features and the contract."""

import numpy as np
import pytest

from bench import load_problem
from problems.classical.family import FUNCTIONS, classical
from problems.classical.instance import MARGIN, instance


def place(problem):
    shares, rotation = instance(*classical.grid.member(problem.name))
    return problem.lower + shares * (problem.upper - problem.lower), rotation


@pytest.mark.sampled(12)
@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("dimension", [2, 10, 100])
def test_the_optimum_is_zero_and_well_within_the_box(function, dimension):
    problem = load_problem(f"classical-{function}-d{dimension}-i3")
    best, _ = place(problem)
    assert problem.evaluate(best[None]).tolist() == [0.0] == [problem.optimum]
    share = (best - problem.lower) / (problem.upper - problem.lower)
    assert (share >= MARGIN - 1e-12).all()
    assert (share <= 1 - MARGIN + 1e-12).all()


def test_an_instance_is_pinned():
    """Another version of numpy may draw other numbers from a seed, which would be other problems of the same names."""
    shares, rotation = instance("rastrigin", 2, 1)
    np.testing.assert_allclose(shares, [0.5756733083722866, 0.11164308380772336], rtol=1e-15)
    np.testing.assert_allclose(rotation[0], [0.2234607477984766, 0.9747129291198234], rtol=1e-14)


@pytest.mark.parametrize("function", [name for name, function in FUNCTIONS.items() if function.separable])
def test_a_separable_function_is_minimised_one_variable_at_a_time(function):
    problem = load_problem(f"classical-{function}-d5-i2", rotate=False)
    assert problem.features["group"].endswith(", separable")
    best, _ = place(problem)
    rng = np.random.default_rng(5)
    for others in rng.uniform(problem.lower, problem.upper, (20, 5)):
        for variable in range(5):
            line = np.tile(others, (201, 1))
            line[:200, variable] = np.linspace(problem.lower[variable], problem.upper[variable], 200)
            line[200, variable] = best[variable]
            values = problem.evaluate(line)
            assert values[200] <= values.min() * (1 + 1e-12)


@pytest.mark.parametrize("function", [name for name, function in FUNCTIONS.items() if not function.separable])
def test_the_others_are_not(function):
    problem = load_problem(f"classical-{function}-d5-i2", rotate=False)
    assert problem.features["group"].endswith(", non-separable")
    best, _ = place(problem)
    lower = []
    for others in np.random.default_rng(5).uniform(problem.lower, problem.upper, (50, 5)):
        line = np.tile(others, (2001, 1))
        line[:2000, 0] = np.linspace(problem.lower[0], problem.upper[0], 2000)
        line[2000, 0] = best[0]
        values = problem.evaluate(line)
        lower.append(values[2000] > values.min())
    assert any(lower)
