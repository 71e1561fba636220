"""Import and compile what a trial needs before its clock starts."""

from __future__ import annotations

import sys

import numpy as np

from bench.contract.objective import scanner
from bench.contract.optimizer import Optimizer
from bench.contract.problem import FunctionProblem, Problem
from bench.contract.typing import Flags, Floats
from bench.sandbox.server import end_if_stuck
from bench.trial import scoring
from bench.trial.trial import search


def warm_problem(problem: Problem, budget: int, *, evaluated: bool = True) -> None:
    """Load the loop of an objective, and find out by one call whether a function takes one point or many.

    A point is ``evaluated`` of a problem that compiles code, and of no other, as that may take long.
    """
    plain = problem.unscored
    compiles = "numba" in sys.modules if plain.compiles is None else plain.compiles
    scanner(budget, problem.dimension)
    if isinstance(plain, FunctionProblem):
        plain.find_out()
    if evaluated and compiles:
        counted = scoring.objective(problem, 1, np.random.default_rng(0))
        counted(points := counted.initial(1))
        problem.describe(points[0])


def warm_optimizer(optimizer: Optimizer, lower: Floats, upper: Floats, integer: Flags | None, budget: int) -> None:
    """Make and discard a short trial on a sphere in a box.

    The problem itself stays unseen, as what an optimizer keeps from here reaches all its trials.
    """
    sphere = FunctionProblem(lambda x: (x * x).sum(axis=1), lower, upper, vectorized=True, integer=integer)
    search(sphere, optimizer, min(budget, 3 * optimizer.minimum_budget), 0, end_if_stuck)
    scanner(budget, len(lower))  # the optimizer may have imported numba
