"""The functions on which whole distributions of final bests are compared, and the protocol of these runs.

Each is 0 at its optimum, which is not the centre of the box, and positive elsewhere (ALO weighs with 1/f).
"""

from functools import cache
from math import cos, pi

import numpy as np
from numba import njit

from bench import FunctionProblem

D, AGENTS, GENERATIONS = 7, 30, 200


def sphere(x):
    total = 0.0
    for k in range(D):
        total += (x[k] - (-4 + 1.5 * k)) ** 2
    return total


def rastrigin(x):
    total = 0.0
    for k in range(D):
        y = x[k] - (-2 + 0.75 * k)
        total += y**2 - 10 * cos(2 * pi * y) + 10
    return total


def rosenbrock(x):
    total = 0.0
    for k in range(D - 1):
        total += 100 * (x[k + 1] - x[k] ** 2) ** 2 + (1 - x[k]) ** 2
    return total


BOXES = {sphere: (-10, 10), rastrigin: (-5.12, 5.12), rosenbrock: (-5, 10)}
FUNCTIONS = {f.__name__: f for f in BOXES}


def rows(f):
    """Return ``f`` of each row of an (n, d) array, compiled."""
    value = njit(f)

    @njit
    def values(x):
        found = np.empty(len(x))
        for i in range(len(x)):
            found[i] = value(x[i])
        return found

    return values


PROBLEMS = {
    name: FunctionProblem(rows(f), [BOXES[f][0]] * D, [BOXES[f][1]] * D, name=name) for name, f in FUNCTIONS.items()
}


class Quick:
    """An objective that counts, clocks and records nothing, which halves the time of a run in tests."""

    def __init__(self, problem, budget, rng):
        self.lower, self.upper, self.dimension, self.budget = problem.lower, problem.upper, problem.dimension, budget
        self.problem, self.rng, self.fun = problem, rng, np.inf

    def initial(self, n):
        return self.lower + (self.upper - self.lower) * self.rng.random((n, self.dimension))

    def repair(self, x):
        return x  # confined to the box already

    def __call__(self, x):
        values = self.problem.evaluate(x)
        self.fun = min(self.fun, values.min())
        return values


@cache
def final_bests(cls, name, runs=200, **options):
    """Return the final bests of an optimizer's runs on the function ``name``, from the seeds 0, 1, …"""
    bests = np.empty(runs)
    for seed in range(runs):
        start, search = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(2))
        objective = Quick(PROBLEMS[name], AGENTS * GENERATIONS, start)
        cls(agents=AGENTS, **options).minimize(objective, search)
        bests[seed] = objective.fun
    return bests
