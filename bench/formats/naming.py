"""Give imported problems this project's names, and look up what their families know of them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import NamedTuple

import numpy as np

from bench.contract.families import Grid, dimension_in
from bench.helpers.errors import BenchError
from bench.plugins import loading, registry, selection


class Known(NamedTuple):
    """The facts on a problem that its family knows, as far as it is installed here.

    Attributes:
        optimum: the best known objective value.
        variables: the names of the search variables, empty where they are unknown.
    """

    optimum: float | None = None
    variables: tuple[str, ...] = ()


def problem_name(suite: str, function: int | str, dimension: int, instance: int, name: str = "") -> str:
    """Return the name of a suite's problem, such as ``"bbob-f08-d5-i1"``; an unknown suite's is of the same form.

    ``name`` is that of the function, by which families know functions that they do not number.
    """
    clean = _clean(suite)
    grid = _grid(clean)
    if grid is not None and name in grid.functions:
        named = name
    else:
        named = f"f{function:02d}" if isinstance(function, int) else _clean(function)
    alone = grid is not None and not grid.instances and instance == 1
    return f"{clean}-{named}-d{dimension}" + ("" if alone else f"-i{instance}")


def _clean(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "unknown"


@cache
def _grid(suite: str) -> Grid | None:
    """Return the functions of a suite, None of an unknown one."""
    with suppress(BenchError):
        return registry.grid(suite) if suite in registry.entries("problems") else None
    return None


@cache
def known(name: str) -> Known:
    """Return the known facts on the problem of that name; none where its family is unknown or not installed."""
    try:
        problem = loading.load_problem(name)
        return Known(None if problem.optimum is None else float(problem.optimum), tuple(problem.variables))
    except Exception:  # a plug-in may raise anything; reports give the reason
        return Known()


def value(name: str, x: Sequence[float]) -> float | None:
    """Return the value of the problem of that name at a point; None where it cannot be computed."""
    try:
        return float(loading.load_problem(name).evaluate(np.array([x], dtype=np.float64))[0])
    except Exception:  # a plug-in may raise anything
        return None


@cache
def is_offered(name: str) -> bool:
    """Return whether an installed family offers a problem of that name, though its library may be missing."""
    if known(name) != Known() or selection.is_of_suite(name):
        return True
    for family in registry.entries("problems"):
        with suppress(Exception):  # a broken family must not hide another's problems
            if name in registry.load("problems", family).names():
                return True
    return False


def dimension_of(name: str) -> int | None:
    """Return the dimension that a problem's name ends with, as in ``bbob-f08-d5-i1``, or that its family knows."""
    return dimension_in(name) or len(known(name).variables) or None


def agrees(printed: str, value: float) -> bool:
    """Return whether a printed decimal number stands for a value, to its last printed digit."""
    number = float(printed)
    mantissa, _, exponent = printed.strip().lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    return abs(number - value) <= 1.01 * 10.0 ** (int(exponent or 0) - digits)
