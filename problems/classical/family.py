"""The problem family ``classical-rastrigin-d30-i2``: function, dimension, instance."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from bench import Problem
from bench.contract.families import Grid, Member
from bench.contract.numbers import require_flag
from bench.contract.typing import Floats
from problems.common import Suite, SuiteProblem, features_of

DIMENSIONS = (2, 3, 5, 10, 20, 30, 40, 50, 100)
INSTANCES = 15


class Function(NamedTuple):
    """A function's usual box, the same for every variable, and what is known of it.

    ``separable``: as in BBOB, the best value of each variable is the same whatever the others are, without a rotation.
    """

    lower: float
    upper: float
    modality: str
    separable: bool


FUNCTIONS = {
    "sphere": Function(-5.12, 5.12, "unimodal", True),
    "ellipsoid": Function(-5, 5, "unimodal", True),
    "cigar": Function(-5, 5, "unimodal", True),
    "step": Function(-100, 100, "unimodal", True),
    "schwefel-1-2": Function(-100, 100, "unimodal", False),
    "schwefel-2-22": Function(-10, 10, "unimodal", True),
    "zakharov": Function(-5, 10, "unimodal", False),
    "rosenbrock": Function(-30, 30, "multimodal", False),
    "rastrigin": Function(-5.12, 5.12, "multimodal", True),
    "ackley": Function(-32, 32, "multimodal", True),
    "griewank": Function(-600, 600, "multimodal", False),
    "levy": Function(-10, 10, "multimodal", True),
    "schwefel-2-26": Function(-500, 500, "multimodal", True),
    "salomon": Function(-100, 100, "multimodal", False),
    "styblinski-tang": Function(-5, 5, "multimodal", True),
}


@cache
def _compiled(function: Callable[[Floats, Floats], None]) -> Callable[[Floats, Floats], None]:
    from numba import njit  # where a problem is loaded, as it takes long

    made: Callable[[Floats, Floats], None] = njit(function, cache=True)
    return made


def _problem(name: str, member: Member, rotate: object = True) -> Problem:
    rotate = require_flag(f"problem {name!r}: rotate", rotate)
    from problems.classical import functions
    from problems.classical.instance import instance, rotated

    function = FUNCTIONS[member.function]
    compute = _compiled(getattr(functions, member.function.replace("-", "_")))
    lower, upper = np.full(member.dimension, function.lower), np.full(member.dimension, function.upper)
    shares, rotation = instance(*member)
    best = lower + shares * (upper - lower)

    def evaluate(x: Floats) -> Floats:
        points = np.ascontiguousarray(x, dtype=np.float64)
        offsets = rotated(points, best, rotation) if rotate else points - best
        values = np.empty(len(offsets))
        compute(offsets, values)
        return values

    evaluate(best[None])  # compile before processes are forked
    separable = function.separable and (not rotate or member.function == "sphere")
    group = f"{function.modality}, {'separable' if separable else 'non-separable'}"
    features = features_of("classical", member, group)
    options = {} if rotate else {"rotate": False}
    known = {"optimum": 0.0, "optimum_point": best, "features": features}
    return SuiteProblem(evaluate, lower, upper, name=name, options=options, **known)


classical = Suite(Grid("classical", dict.fromkeys(FUNCTIONS, DIMENSIONS), INSTANCES), _problem, ("rotate",))
