"""The compiled functions against the formulas of the literature, written plainly in its own variable."""

import numpy as np
import pytest

from bench import load_problem
from problems.classical.family import FUNCTIONS, classical
from problems.classical.instance import instance

I = np.arange(1, 7)  # noqa: E741 - the literature's index; the tests have six variables
D = 6


def rosenbrock(z):
    return np.sum(100 * (z[:-1] ** 2 - z[1:]) ** 2 + (1 - z[:-1]) ** 2)


def schwefel(z):
    def g(value):
        size = abs(value)
        if size <= 500:
            return value * np.sin(size**0.5)
        inside = 500 - size % 500
        return np.sign(value) * inside * np.sin(inside**0.5) - (size - 500) ** 2 / (10_000 * D)

    return 418.98288727243374 * D - sum(map(g, z))


def levy(z):
    w = 1 + z / 4
    inner = np.sum((w[:-1] - 1) ** 2 * (1 + 10 * np.sin(np.pi * w[1:]) ** 2))
    return np.pi / D * (10 * np.sin(np.pi * w[0]) ** 2 + inner + (w[-1] - 1) ** 2)


LITERATURE = {  # function: (the optimum z*, the formula)
    "sphere": (0, lambda z: np.sum(z**2)),
    "ellipsoid": (0, lambda z: np.sum(1e6 ** ((I - 1) / (D - 1)) * z**2)),
    "cigar": (0, lambda z: z[0] ** 2 + 1e6 * np.sum(z[1:] ** 2)),
    "step": (0, lambda z: np.sum(np.floor(z + 0.5) ** 2)),
    "schwefel-1-2": (0, lambda z: np.sum(np.cumsum(z) ** 2)),
    "schwefel-2-22": (0, lambda z: np.sum(np.abs(z)) + np.prod(np.abs(z))),
    "zakharov": (0, lambda z: np.sum(z**2) + np.sum(0.5 * I * z) ** 2 + np.sum(0.5 * I * z) ** 4),
    "rosenbrock": (1, rosenbrock),
    "rastrigin": (0, lambda z: 10 * D + np.sum(z**2 - 10 * np.cos(2 * np.pi * z))),
    "ackley": (
        0,
        lambda z: -20 * np.exp(-0.2 * np.sqrt(np.mean(z**2))) - np.exp(np.mean(np.cos(2 * np.pi * z))) + 20 + np.e,
    ),
    "griewank": (0, lambda z: np.sum(z**2) / 4000 - np.prod(np.cos(z / np.sqrt(I))) + 1),
    "levy": (0, levy),
    "schwefel-2-26": (420.9687463599821, schwefel),
    "salomon": (0, lambda z: 1 - np.cos(2 * np.pi * np.linalg.norm(z)) + 0.1 * np.linalg.norm(z)),
    "styblinski-tang": (-2.903534027771177, lambda z: 0.5 * np.sum(z**4 - 16 * z**2 + 5 * z) + 39.16616570377142 * D),
}


@pytest.fixture
def six(monkeypatch):
    """Let the family have six dimensions, which no rule of thumb has."""
    for name in FUNCTIONS:
        monkeypatch.setitem(classical.grid.functions, name, (D,))


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("rotate", [True, False])
def test_values_are_those_of_the_formula(name, rotate, six):
    problem = load_problem(f"classical-{name}-d{D}-i2", rotate=rotate)
    shares, rotation = instance(name, D, 2)
    best = problem.lower + shares * (problem.upper - problem.lower)
    at, formula = LITERATURE[name]
    x = np.random.default_rng(8).uniform(problem.lower, problem.upper, (50, D))
    z = (x - best) @ (rotation if rotate else np.eye(D)) + at
    expected = [formula(row) for row in z]
    np.testing.assert_allclose(problem.evaluate(x), expected, rtol=1e-9)
