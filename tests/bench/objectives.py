"""Objectives for the tests of what an objective does."""

import numpy as np

from bench import FunctionProblem, Objective


def sphere(dimension=3, **options):
    return FunctionProblem(lambda x: (x**2).sum(axis=1), [-5.0] * dimension, [5.0] * dimension, **options)


LOOPS = []
"""The loop by which objectives look at their points; the fixture ``scanner`` puts one here after the other."""


def objective(problem=None, budget=10, seed=0, *arguments, **limits):
    made = Objective(problem or sphere(), budget, np.random.default_rng(seed), *arguments, **limits)
    made._scan = LOOPS[0]
    return made
