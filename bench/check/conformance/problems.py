"""The problems on which optimizers are checked; each is demanding for one rule."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bench.problem import Floats, FunctionProblem

Values = Callable[[Floats, Floats], Floats]

# The ordinary box, uneven and without the origin, and the place of the optimum as a share of its widths; they are
# repeated up to the number of variables.
_LOWER, _UPPER, _BEST = (-2.0, 10.0, -1000.0), (5.0, 10.5, -10.0), (0.3, 0.65, 0.8)


def bowl(dimension: int = 3, **naming: Any) -> FunctionProblem:
    """Return the ordinary problem: a paraboloid whose optimum is neither at the centre nor on the diagonal."""
    return _problem(lambda _, f: f, dimension, **naming)


def corner() -> FunctionProblem:
    """Return a plane that falls towards a corner of a box of widths 1e-3, 1e-6 and 4.9e4 far from the origin."""
    lower, upper = np.array([100.0, 1e-3, -5e4]), np.array([100.001, 1.001e-3, -1e3])
    slope = np.array([1.0, -1.0, 1.0])
    return FunctionProblem(lambda x: ((x - lower) / (upper - lower)) @ slope, lower, upper, name="corner")


def half() -> FunctionProblem:
    """Return a problem whose own repair moves points into one half of the box."""
    problem = bowl()
    least = problem.lower.copy()
    least[0] = (problem.lower[0] + problem.upper[0]) / 2
    problem.repair = lambda x: np.clip(x, least, problem.upper)  # type: ignore[method-assign]
    return problem


def odd() -> dict[str, FunctionProblem]:
    """Return problems with values that are rare but allowed, by their description."""
    kinds: dict[str, Values] = {
        "equal values": lambda _, f: np.zeros_like(f),
        "+inf everywhere": lambda _, f: np.full_like(f, np.inf),
        "+inf and NaN in half of the box": lambda u, f: np.select([u[:, 0] > 0.75, u[:, 0] > 0.5], [np.nan, np.inf], f),
        "values of 1e300": lambda _, f: f * 1e300,
        "values of 1e-300": lambda _, f: f * 1e-300,
        "negative values": lambda _, f: f - 1e6,
    }
    return {name: _problem(values, 3, name=name) for name, values in kinds.items()}


def _problem(values: Values, dimension: int, **naming: Any) -> FunctionProblem:
    """Return a problem of the shares ``u`` of the box and the paraboloid's values ``f`` in the ordinary box."""
    lower, upper, best = (np.resize(each, dimension) for each in (_LOWER, _UPPER, _BEST))

    def evaluate(x: Floats) -> Floats:
        u = (x - lower) / (upper - lower)
        return values(u, ((u - best) ** 2).sum(axis=1))

    return FunctionProblem(evaluate, lower, upper, **naming)
