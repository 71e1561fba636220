"""Objectives for the tests of what an objective does."""

import numpy as np

from bench import FunctionProblem, Objective


def sphere(dimension=3, **options):
    return FunctionProblem(lambda x: (x**2).sum(axis=1), [-5.0] * dimension, [5.0] * dimension, **options)


def objective(problem=None, budget=10, seed=0, **limits):
    return Objective(problem or sphere(), budget, np.random.default_rng(seed), **limits)
