"""The families ``sbox-cost``, ``ma-bbob`` and ``star-discrepancy``, computed by IOHprofiler's package ``ioh``.

- ``sbox-cost-f08-d5-i1``: the functions of bbob with their optimum anywhere in the box, and +inf outside. Source:
  Vermetten, López-Ibáñez, Mersmann, Allmendinger and Kononova 2023, "Analysis of modular CMA-ES on strict
  box-constrained problems in the SBOX-COST benchmarking suite", GECCO companion.
- ``ma-bbob-f0017-d5``: MA-BBOB, affine combinations of bbob functions with random weights and a random optimum. ioh
  calls them instances and draws them from their number; they are functions here, because each is a landscape of its own
  and no repetition of another. Source: Vermetten, Ye, Bäck and Doerr 2023, "MA-BBOB: A Problem Generator for Black-Box
  Optimization Using Affine Combinations and Shifts", arXiv:2312.11083.
- ``star-discrepancy-uniform-100-d3-i1``: the local star discrepancy of 10 to 1000 points of a uniform, Sobol' or Halton
  sampler in the unit cube, whose seed is the instance; some instances of ioh's have the same points. It is to be
  maximised, so its negative is minimised; no maximum is known. Source: Clément, Vermetten, de Nobel, Jesus, Paquete and
  Doerr 2023, "Computing Star Discrepancies with Numerical Black-Box Optimization Algorithms", GECCO.
"""

from __future__ import annotations

from itertools import product
from types import ModuleType
from typing import Any

import numpy as np

from bench import Problem
from bench.contract.families import Grid, Member
from bench.contract.typing import Floats
from bench.helpers.errors import require
from problems.bbob.noiseless import FUNCTIONS, GROUPS, TITLES
from problems.common import Suite, SuiteProblem, features_of, group_of

DIMENSIONS = (2, 3, 5, 10, 20, 40)
INSTANCES = 15
AFFINE = range(1, 1001)
SAMPLERS = ("uniform", "sobol", "halton")
SAMPLES = (10, 25, 50, 100, 150, 200, 250, 500, 750, 1000)
DISCREPANCIES = {f"{kind}-{n}": 30 + number for number, (kind, n) in enumerate(product(SAMPLERS, SAMPLES))}
"""ioh's number of each function of ``star-discrepancy``."""


def _made(name: str, function: Any, features: dict[str, str | int], sign: float = 1.0) -> SuiteProblem:
    """Return the problem of a function of ioh; with a sign of -1, of its negative, whose optimum is unknown."""

    def evaluate(x: Floats) -> Floats:
        values = function(x.tolist()) if len(x) else []  # lists take less time than arrays
        return sign * np.array(values, dtype=np.float64)

    known = {"optimum": function.optimum.y, "optimum_point": function.optimum.x} if sign > 0 else {}
    return SuiteProblem(evaluate, function.bounds.lb, function.bounds.ub, name=name, features=features, **known)


def _package(name: str) -> ModuleType:
    return require("ioh", "ioh", f"problem {name!r} needs")


def _boxed(name: str, member: Member) -> Problem:
    ioh, number = _package(name), int(member.function[1:])
    function = ioh.get_problem(number, member.instance, member.dimension, ioh.ProblemClass.SBOX)
    return _made(name, function, features_of("sbox-cost", member, group_of(number, GROUPS)))


def _affine(name: str, member: Member) -> Problem:
    function = _package(name).problem.ManyAffine(int(member.function[1:]), member.dimension)
    return _made(name, function, features_of("ma-bbob", member, "affine combination"))


def _discrepancy(name: str, member: Member) -> Problem:
    ioh, number = _package(name), DISCREPANCIES[member.function]
    function = ioh.get_problem(number, member.instance, member.dimension, ioh.ProblemClass.STAR_REAL)
    features = features_of("star-discrepancy", member, f"{member.function.partition('-')[0]} points")
    problem = _made(name, function, features, sign=-1.0)
    problem.measure = "minus the local star discrepancy"
    return problem


sbox_cost = Suite(Grid("sbox-cost", {f"f{n:02d}": DIMENSIONS for n in FUNCTIONS}, INSTANCES, TITLES), _boxed)
ma_bbob = Suite(Grid("ma-bbob", {f"f{n:04d}": DIMENSIONS for n in AFFINE}), _affine)
star_discrepancy = Suite(
    Grid("star-discrepancy", dict.fromkeys(DISCREPANCIES, (2, 3, 5, 10, 20)), INSTANCES), _discrepancy
)
