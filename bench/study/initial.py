"""Points of a problem that are known before a search, from a list or from a CSV file."""

from __future__ import annotations

import csv
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from bench.contract.numbers import is_finite
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError, explained

Points = tuple[tuple[float, ...], ...]


def known_points(given: Any, where: str = "given") -> Points:
    """Return points as tuples of numbers.

    Args:
        given: a list of points, an array (k, d), or the name of a CSV file with one point in each line, whose columns
            are the variables in their order; a first line of names is passed over.
        where: the study, for messages.

    Raises:
        BenchError: for anything else.
    """
    rows = given.tolist() if isinstance(given, np.ndarray) else given
    if isinstance(given, str | Path):
        with explained(f"study {where}: the points in {given} cannot be read", (OSError, ValueError, csv.Error)):
            lines = [line for line in csv.reader(Path(given).read_text(encoding="utf-8-sig").splitlines()) if line]
            rows = [_numbers(line) for line in lines]
            rows = rows[1:] if rows and isinstance(rows[0][0], str) else rows
    lists = isinstance(rows, list | tuple) and rows and all(isinstance(row, list | tuple) and row for row in rows)
    if not lists or not all(is_finite(value) for row in rows for value in row) or len({*map(len, rows)}) > 1:
        raise BenchError(
            f"study {where}: 'initial' must be a list of points of one dimension, as in [[0.5, 2.0]], or a CSV file of "
            "them"
        )
    return tuple(tuple(map(float, row)) for row in rows)


def with_initial(problem: Problem, points: Points) -> Problem:
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


def _numbers(texts: list[str]) -> list[float] | list[str]:
    with suppress(ValueError):
        return [float(text) for text in texts]
    return texts
