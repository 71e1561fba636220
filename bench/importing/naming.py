"""Give imported problems this project's names, and look up what their families know of them."""

from __future__ import annotations

import re
from contextlib import suppress
from functools import cache
from typing import NamedTuple

from bench.errors import BenchError
from bench.families import Grid, dimension_in
from bench.plugins import loading, registry, selection


class Known(NamedTuple):
    """What the family of a problem says of it, as far as it is installed here.

    Attributes:
        optimum: the best known objective value.
        variables: the names of the search variables, empty where they are unknown.
    """

    optimum: float | None = None
    variables: tuple[str, ...] = ()


def problem_name(suite: str, function: int | str, dimension: int, instance: int) -> str:
    """Return the name of a suite's problem, such as ``"bbob-f08-d5-i1"``; an unknown suite's is of the same form."""
    clean = _clean(suite)
    if isinstance(function, int):
        named = _functions(clean).get(function, f"f{function:02d}")
    else:
        named = _clean(function)
    return f"{clean}-{named}-d{dimension}-i{instance}"


def _clean(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "unknown"


@cache
def _functions(suite: str) -> dict[int, str]:
    """Return the names of a suite's functions by number, as its family spells them; empty for an unknown suite."""
    if suite not in registry.entries("problems"):
        return {}
    try:
        grid = getattr(registry.load("problems", suite), "grid", None)
    except BenchError:
        return {}
    names = grid.functions if isinstance(grid, Grid) else ()
    return {int(name[1:]): name for name in names if re.fullmatch(r"f\d+", name)}


@cache
def known(name: str) -> Known:
    """Return what is known of the problem of that name; nothing where its family is unknown or not installed."""
    try:
        problem = loading.load_problem(name)
        return Known(None if problem.optimum is None else float(problem.optimum), tuple(problem.variables))
    except Exception:  # a plug-in may raise anything; reports give the reason
        return Known()


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
