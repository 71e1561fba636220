"""Points of a problem that are known before a search, from a list or from a CSV file."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from bench.contract.problem import Problem
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError, explained


def known_points(given: Any, where: str = "given") -> list[list[float]]:
    """Return points as lists of numbers.

    Args:
        given: a list of points, an array (k, d), or the name of a CSV file with one point in each line, whose columns
            are the variables in their order; a first line of names is passed over.
        where: the study, for messages.

    Raises:
        BenchError: for anything else.
    """
    points: Floats = np.empty(0)
    with explained(f"study {where}: the points in {given} cannot be read"), suppress(TypeError, ValueError):
        if isinstance(given, str | Path):
            with Path(given).open(encoding="utf-8-sig") as file:
                points = np.genfromtxt(file, delimiter=",", ndmin=2)
            points = points[1:] if np.isnan(points[:1]).all() else points
        else:
            points = np.array(given, dtype=np.float64)
    if points.ndim != 2 or not points.size or not np.isfinite(points).all():
        raise BenchError(
            f"study {where}: 'initial' must be a list of points of one dimension, as in [[0.5, 2.0]], or a CSV file of "
            "them"
        )
    return [[*map(float, point)] for point in points]


def with_initial(problem: Problem, points: Sequence[Sequence[float]]) -> Problem:
    """Return the problem with these points as known before a search; raises BenchError where its box lacks them."""
    if points:
        array = np.array(points)
        if array.shape[1] != problem.dimension:
            raise BenchError(
                f"problem {problem.name!r}: a point of 'initial' has {array.shape[1]} numbers, and the problem has "
                f"{problem.dimension} variables"
            )
        if (out := ((array < problem.lower) | (array > problem.upper)).any(axis=1)).any():
            raise BenchError(
                f"problem {problem.name!r}: the point {points[int(out.argmax())]} of 'initial' lies outside the box"
            )
        object.__setattr__(problem, "initial_points", array)  # also of a frozen dataclass
    return problem
