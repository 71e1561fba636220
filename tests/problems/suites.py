"""What the tests of the suites share: searches that try to beat an optimum, and the contract of a suite's problem."""

import pickle

import numpy as np
from scipy.optimize import minimize

from bench import load_problem


def best_found(problem, start=None, points=10_000):
    """Return the best value of random points in the box and of local searches from the best of them and from start."""
    rng = np.random.default_rng(7)
    x = rng.uniform(problem.lower, problem.upper, (points, problem.dimension))
    values = problem.evaluate(x)
    starts = [x[values.argmin()]] if start is None else [x[values.argmin()], problem.repair(start)]
    bounds = list(zip(problem.lower, problem.upper, strict=True))
    found = [
        minimize(lambda point: problem.evaluate(point[None])[0], each, method="Nelder-Mead", bounds=bounds,
                 options={"maxfev": 2000, "xatol": 0, "fatol": 0}).fun
        for each in starts
    ]  # fmt: skip
    return min(values.min(), *found)


def assert_pure_and_reloadable(problem):
    """Values depend on the point alone: not on its batch, its memory, earlier calls, or the process that loaded it."""
    rng = np.random.default_rng(3)
    x = rng.uniform(problem.lower, problem.upper, (17, problem.dimension))
    values = problem.evaluate(x)
    assert values.shape == (17,)
    assert values.dtype == np.float64
    single = np.concatenate([problem.evaluate(row[None]) for row in x])
    np.testing.assert_array_equal(single, values)
    np.testing.assert_array_equal(problem.evaluate(np.asfortranarray(x))[::-1], problem.evaluate(x[::-1]))
    assert problem.evaluate(x[:0]).shape == (0,)
    for again in (load_problem(problem.name), pickle.loads(pickle.dumps(problem))):
        assert (again.name, again.optimum, again.features) == (problem.name, problem.optimum, problem.features)
        np.testing.assert_array_equal(again.evaluate(x), values)
