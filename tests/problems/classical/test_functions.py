"""The compiled functions against the formulas of the literature, written plainly in its own variable."""

import numpy as np
import pytest

from bench import load_problem
from problems.classical.family import FUNCTIONS, classical
from problems.classical.instance import instance

I = np.arange(1, 7)  # noqa: E741 - the literature's index; the tests have six variables
D = 6


def neighbours(z):
    return z[:-1], z[1:]


def circle(z):
    return z, np.roll(z, -1)


def rosenbrock_terms(a, b):
    return 100 * (a**2 - b) ** 2 + (1 - a) ** 2


def schaffer_f7(z):
    r = np.hypot(*neighbours(z))
    return np.mean(np.sqrt(r) + np.sqrt(r) * np.sin(50 * r**0.2) ** 2) ** 2


def schaffer_f6(z):
    s = sum(each**2 for each in circle(z))
    return np.sum(0.5 + (np.sin(np.sqrt(s)) ** 2 - 0.5) / (1 + 0.001 * s) ** 2)


def schwefel(z):
    def g(value):
        size = abs(value)
        if size <= 500:
            return value * np.sin(size**0.5)
        inside = 500 - size % 500
        return np.sign(value) * inside * np.sin(inside**0.5) - (size - 500) ** 2 / (10_000 * D)

    return 418.98288727243374 * D - sum(map(g, z))


def weierstrass(z):
    k = np.arange(21)[:, None]
    waves = 0.5**k * np.cos(2 * np.pi * 3.0**k * (z + 0.5))
    return waves.sum() - D * np.sum(0.5**k * np.cos(np.pi * 3.0**k))


def katsuura(z):
    j = np.arange(1, 33)[:, None]
    t = 2.0**j * z
    sums = np.sum(np.abs(t - np.floor(t + 0.5)) / 2.0**j, axis=0)
    return 10 / D**2 * np.prod((1 + I * sums) ** (10 / D**1.2)) - 10 / D**2


def levy(z):
    w = 1 + z / 4
    inner = np.sum((w[:-1] - 1) ** 2 * (1 + 10 * np.sin(np.pi * w[1:]) ** 2))
    return np.pi / D * (10 * np.sin(np.pi * w[0]) ** 2 + inner + (w[-1] - 1) ** 2)


def lunacek(z):
    s = 1 - 1 / (2 * np.sqrt(D + 20) - 8.2)
    mu = -np.sqrt((2.5**2 - 1) / s)
    bowls = min(np.sum((z - 2.5) ** 2), D + s * np.sum((z - mu) ** 2))
    return bowls + 10 * np.sum(1 - np.cos(2 * np.pi * (z - 2.5)))


def griewank_rosenbrock(z):
    t = rosenbrock_terms(*circle(z))
    return np.sum(t**2 / 4000 - np.cos(t) + 1)


def happy_cat(z):
    square = np.sum(z**2)
    return ((square - D) ** 2) ** 0.125 + (0.5 * square + z.sum()) / D + 0.5


LITERATURE = {  # function: (the optimum z*, the formula)
    "sphere": (0, lambda z: np.sum(z**2)),
    "ellipsoid": (0, lambda z: np.sum(1e6 ** ((I - 1) / (D - 1)) * z**2)),
    "cigar": (0, lambda z: z[0] ** 2 + 1e6 * np.sum(z[1:] ** 2)),
    "discus": (0, lambda z: 1e6 * z[0] ** 2 + np.sum(z[1:] ** 2)),
    "different-powers": (0, lambda z: np.sum(np.abs(z) ** (2 + 10 * (I - 1) / (D - 1)))),
    "sharp-ridge": (0, lambda z: z[0] ** 2 + 100 * np.linalg.norm(z[1:])),
    "step": (0, lambda z: np.sum(np.floor(z + 0.5) ** 2)),
    "schwefel-1-2": (0, lambda z: np.sum(np.cumsum(z) ** 2)),
    "schwefel-2-22": (0, lambda z: np.sum(np.abs(z)) + np.prod(np.abs(z))),
    "zakharov": (0, lambda z: np.sum(z**2) + np.sum(0.5 * I * z) ** 2 + np.sum(0.5 * I * z) ** 4),
    "rosenbrock": (1, lambda z: np.sum(rosenbrock_terms(*neighbours(z)))),
    "rastrigin": (0, lambda z: 10 * D + np.sum(z**2 - 10 * np.cos(2 * np.pi * z))),
    "ackley": (
        0,
        lambda z: -20 * np.exp(-0.2 * np.sqrt(np.mean(z**2))) - np.exp(np.mean(np.cos(2 * np.pi * z))) + 20 + np.e,
    ),
    "griewank": (0, lambda z: np.sum(z**2) / 4000 - np.prod(np.cos(z / np.sqrt(I))) + 1),
    "levy": (0, levy),
    "schwefel-2-26": (420.9687463599821, schwefel),
    "weierstrass": (0, weierstrass),
    "katsuura": (0, katsuura),
    "salomon": (0, lambda z: 1 - np.cos(2 * np.pi * np.linalg.norm(z)) + 0.1 * np.linalg.norm(z)),
    "schaffer-f6": (0, schaffer_f6),
    "schaffer-f7": (0, schaffer_f7),
    "styblinski-tang": (-2.903534027771177, lambda z: 0.5 * np.sum(z**4 - 16 * z**2 + 5 * z) + 39.16616570377142 * D),
    "happy-cat": (-1, happy_cat),
    "griewank-rosenbrock": (1, griewank_rosenbrock),
    "lunacek": (2.5, lunacek),
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
    np.testing.assert_allclose(problem.evaluate(x), expected, rtol=1e-6 if name == "weierstrass" else 1e-9)
