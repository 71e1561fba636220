"""The compiled functions of COCO, their optimal values, and its generator of random numbers, for all its suites."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.errors import require

BOX = 5.0  # every continuous variable is searched in [-5, 5]
INSTANCES = 15  # a COCO experiment has 15 instances of each function and dimension

_MODULUS, _FACTOR, _QUOTIENT, _REMAINDER = 2147483647, 16807, 127773, 2836


def function_of(suite: str, name: str, index: int, dimension: int, instance: int) -> Any:
    """Return COCO's function object.

    Args:
        suite: COCO's name of the suite.
        name: the problem's name, for the message where the package ``coco-experiment`` is missing.
        index: of the function in its suite, from 1.
        dimension: the number of variables.
        instance: the number of the instance, from 1.
    """
    cocoex = require("cocoex", "suites", f"problem {name!r} needs")
    return cocoex.Suite(suite, f"instances: {instance}", f"dimensions: {dimension} function_indices: {index}")[0]


def optimum_of(number: int, instance: int) -> float:
    """Return the optimal value f_opt of an instance of a bbob function, which depends on no dimension."""
    cocoex = require("cocoex", "suites", "its optimal value needs")
    return float(cocoex.BareProblem("bbob", number, 2, instance).best_value())


def bbob_function(name: str, number: int, dimension: int, instance: int) -> Callable[[Floats], Floats]:
    """Return a function of the suite bbob as one of (n, d) points, which COCO evaluates in one call."""
    cocoex = require("cocoex", "suites", f"problem {name!r} needs")
    function = cocoex.BareProblem("bbob", number, dimension, instance)

    def evaluate(x: Floats) -> Floats:
        if x.shape != (len(x), dimension):  # C would read beyond the array
            raise ValueError(f"expected points of shape (n, {dimension}), got {x.shape}")
        values: Floats = function(np.ascontiguousarray(x, np.float64))
        return values

    return evaluate


def evaluated(function: Callable[[Floats], float]) -> Callable[[Floats], Floats]:
    """Return a function object of COCO, which evaluates one point a call, as a function of (n, d) points."""
    return lambda x: np.fromiter(map(function, x), np.float64, len(x))


# BBOB's instances are drawn by the generator of Park and Miller (1988, Communications of the ACM 31) with a shuffle of
# Bays and Durham (1976), as its definition of 2009 has it; the suites below need what COCO's package does not offer.


def uniform(n: int, seed: int) -> Floats:
    """Return (n,) uniform numbers from 0 to 1."""
    state = max(abs(seed), 1)
    table = [0] * 32
    for position in range(39, -1, -1):  # the first eight are dropped
        state = _next(state)
        if position < 32:
            table[position] = state
    drawn, numbers = table[0], np.empty(n)
    for position in range(n):
        state = _next(state)
        slot = drawn // 67108865  # 0 to 31
        drawn, table[slot] = table[slot], state
        numbers[position] = drawn / _MODULUS or 1e-99
    return numbers


def _next(state: int) -> int:
    high = state // _QUOTIENT
    state = _FACTOR * (state - high * _QUOTIENT) - _REMAINDER * high
    return state + _MODULUS if state < 0 else state


def rotation(d: int, seed: int) -> Floats:
    """Return a random rotation, (d, d): normal columns (Box and Muller 1958), made orthonormal one after the other."""
    draws = uniform(2 * d * d, seed)
    normal = np.sqrt(-2 * np.log(draws[: d * d])) * np.cos(2 * np.pi * draws[d * d :])
    matrix: Floats = normal.reshape(d, d).T.copy()
    for column in range(d):
        for before in range(column):
            matrix[:, column] -= (matrix[:, column] @ matrix[:, before]) * matrix[:, before]
        matrix[:, column] /= np.sqrt(matrix[:, column] @ matrix[:, column])
    return matrix


def optimal_point(d: int, seed: int) -> Floats:
    """Return the (d,) optimal point x_opt of most functions, in [-4, 4] to four decimals; no coordinate is 0."""
    point = 8 * np.floor(1e4 * uniform(d, seed)) / 1e4 - 4
    return np.where(point == 0, -1e-5, point)
