"""Points of a problem that are known before a search, from a list or from a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from bench.contract.problem import Problem
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError, explained
from bench.helpers.text import listed

Known = Sequence[Sequence[float | str]]
"""Points, the first of which may be names of variables instead."""


def known_points(given: Any, where: str = "given") -> list[list[float | str]]:
    """Return points as lists of numbers, after the names of their columns where they have any.

    Args:
        given: a list of points, an array (k, d), or the name of a CSV file with one point in each line. A first line of
            names of variables says which column is which.
        where: the study, for messages.

    Raises:
        BenchError: for anything else.
    """
    names: list[list[float | str]] = []
    points: Floats = np.empty(0)
    with explained(f"study {where}: the points in {given} cannot be read"), suppress(TypeError, ValueError):
        if isinstance(given, str | Path):
            with Path(given).open(encoding="utf-8-sig", newline="") as file:
                given = [[_number(cell.strip()) for cell in row] for row in csv.reader(file) if row]
        rows = [[*row] for row in given]
        names = [rows.pop(0)] if rows and all(isinstance(cell, str) for cell in rows[0]) else []
        points = np.array(rows, dtype=np.float64)
    is_table = points.ndim == 2 and points.size and all(len(row) == points.shape[1] for row in names)
    if not is_table or not np.isfinite(points).all():
        raise BenchError(
            f"study {where}: 'initial' must be a list of points of one dimension, as in [[0.5, 2.0]], or a CSV file of "
            "them"
        )
    found: list[list[float | str]] = points.tolist()
    return names + found


def _number(cell: str) -> float | str:
    with suppress(ValueError):
        return float(cell)
    return cell


def with_initial(problem: Problem, known: Known) -> Problem:
    """Return the problem with these points as known before a search.

    Raises:
        BenchError: where its box lacks one, and for columns of which some are named as variables, and others are not.
    """
    if not known:
        return problem
    names = [str(name) for name in known[0]] if isinstance(known[0][0], str) else []
    points: Floats = np.array(known[1:] if names else known, dtype=np.float64)
    if points.shape[1] != problem.dimension:
        raise BenchError(
            f"problem {problem.name!r}: a point of 'initial' has {points.shape[1]} numbers, and the problem has "
            f"{problem.dimension} variables"
        )
    if sorted(names) == sorted(problem.variables):
        points = points[:, [names.index(name) for name in problem.variables]]
    elif {*names} & {*problem.variables}:
        raise BenchError(
            f"problem {problem.name!r}: the columns of 'initial' are {listed(names)}, and the variables are "
            f"{listed(problem.variables)}"
        )
    if (out := ((points < problem.lower) | (points > problem.upper)).any(axis=1)).any():
        point = points[int(out.argmax())].tolist()
        raise BenchError(f"problem {problem.name!r}: the point {point} of 'initial' lies outside the box")
    object.__setattr__(problem, "initial_points", points)  # also of a frozen dataclass
    return problem
