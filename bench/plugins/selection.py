"""Select many problems at once: by a pattern of their names, or by functions, dimensions and instances of a suite."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
from contextlib import suppress
from fnmatch import translate
from itertools import islice

from bench.contract.families import LARGEST_INSTANCE, Grid, nearest_function
from bench.contract.numbers import is_whole
from bench.helpers.errors import BenchError, nearest
from bench.plugins import registry

MOST = 100_000
"""The largest number of problems that one pattern or table may select: each is loaded before a study begins."""

KEYS = ("suite", "functions", "dimensions", "instances")


def matching(pattern: str) -> list[str]:
    """Return the problems whose names match a pattern such as ``"bbob-f*-d5-*"``, or the name if it is no pattern.

    ``*`` stands for any characters, ``?`` for one, ``[13]`` for one of these. Of a suite, all functions, all dimensions
    and the first instances are searched; of another family, the names that it lists.

    Raises:
        BenchError: where none or more than 100,000 problems match.
    """
    if ":" in pattern or not re.search(r"[*?[]", pattern):  # recording:<path> may hold any character
        return [pattern]
    matches = re.compile(translate(pattern)).fullmatch
    names = list(islice(filter(matches, _all_names()), MOST + 1))
    if not names:
        raise BenchError(f"no problem matches {pattern!r}; 'bench list problems' shows the families")
    return _limited(names, repr(pattern))


def members(name: str) -> list[str]:
    """Return the problems that a family lists, or those of a pattern, or the name; raises BenchError as matching."""
    if name in registry.entries("problems"):
        return list(registry.load("problems", name).names())
    return matching(name)


def selected(suite: object, functions: object = None, dimensions: object = None, instances: object = None) -> list[str]:
    """Return the names of a suite's problems by what a ``[[problems]]`` table says.

    Args:
        suite: the name of a family with a grid.
        functions: a number or a name, a range of numbers such as ``"1-24"``, or a list of these; by default all.
        dimensions: a number or a range, or a list of these; by default all. A function is left out in the dimensions
            that it does not have.
        instances: likewise; by default the first of the suite, such as 1 to 15.

    Raises:
        BenchError: for a function, dimension or instance that there is not, and for more than 100,000 problems. Both
            ends of a range must exist; the numbers between them may have gaps.
    """
    grid = _grid(suite)
    if instances is not None and not grid.instances:
        raise BenchError(f"the problems of {suite} have no instances; leave them out")
    chosen = None if functions is None else _functions(grid, functions)
    sizes = None if dimensions is None else _numbers(dimensions, "dimension", grid, grid.dimensions)
    numbers = None if instances is None else _numbers(instances, "instance", grid, range(1, LARGEST_INSTANCE + 1))
    names = list(islice(grid.names(chosen, sizes, numbers), MOST + 1))
    if not names:
        raise BenchError(f"no function selected from {suite} has any of the dimensions {dimensions!r}")
    return _limited(names, f"the selection from {suite}")


def _limited(names: list[str], what: str) -> list[str]:
    if len(names) > MOST:
        raise BenchError(f"{what} stands for more than {MOST:,} problems; select fewer")
    return names


def is_of_suite(problem: str) -> bool:
    """Return whether a problem's name is that of a suite's problem, a family with a grid; the problem is not loaded."""
    families = registry.entries("problems")
    for family in (suite for suite in families if problem.startswith(f"{suite}-")):
        with suppress(Exception, SystemExit):  # a broken family, or the name of another one
            grid = registry.grid(family)
            if grid and grid.member(problem):
                return True
    return False


def list_problems(pattern: str = "*") -> list[str]:
    """Return the names of the problems that match a pattern such as ``"bbob-f*-d5-i1"``; by default all.

    Of a suite these are all functions and dimensions with the first instances. Families that take any file or text,
    such as ``recording:<path>``, list none.
    """
    return list(filter(re.compile(translate(pattern)).fullmatch, _all_names()))


def _all_names() -> Iterator[str]:
    """Yield the names of every problem that can be listed, and of all that are on a grid."""
    for family in registry.entries("problems"):
        with suppress(Exception, SystemExit):  # a broken family must not hide another's problems
            yield from (registry.grid(family) or registry.load("problems", family)).names()


def _grid(suite: object) -> Grid:
    families = registry.entries("problems")
    if not isinstance(suite, str) or suite not in families:
        raise BenchError(f"unknown suite {suite!r}{nearest(str(suite), families)}")
    grid = registry.grid(suite)
    if grid is None:
        raise BenchError(f"the problems of {suite!r} are no suite with functions and dimensions; give their names")
    return grid


def _functions(grid: Grid, chosen: object) -> list[str]:
    """Return the names of functions that are given as numbers, ranges or names."""
    numbered = {int(name[1:]): name for name in grid.functions if re.fullmatch(r"f\d+", name)}
    names: list[str] = []
    for item in _items(chosen, "functions"):
        if isinstance(item, str) and item in grid.functions:
            own = [item]
        else:
            own = [numbered[number] for number in _span(item, numbered)]
        if not own:
            raise BenchError(f"{grid.suite} has no function {item!r}{nearest_function(str(item), grid.functions)}")
        names += own
    return list(dict.fromkeys(names))


def _numbers(chosen: object, what: str, grid: Grid, offered: list[int] | range) -> list[int]:
    """Return the numbers that are given as such or as ranges, among those that there are."""
    numbers: list[int] = []
    for item in _items(chosen, f"{what}s"):
        own = _span(item, offered)
        if not own:
            there = f"{offered[0]} to {offered[-1]}" if isinstance(offered, range) else ", ".join(map(str, offered))
            raise BenchError(f"{grid.suite} has no {what} {item!r}; it has {there}")
        numbers += own
    return list(dict.fromkeys(numbers))


def _items(selection: object, what: str) -> list[object]:
    """Return a list of numbers and texts; ``"1-5, 8"`` has two."""
    if selection == []:
        raise BenchError(f"a list of {what} is empty; leave it out to select all")
    items: list[object] = []
    for item in selection if isinstance(selection, list) else [selection]:
        items += [part.strip() for part in item.split(",")] if isinstance(item, str) else [item]
    return items


def _span(item: object, offered: Container[int]) -> list[int]:
    """Return the numbers that a number or a range such as ``"1-24"`` stands for; none where an end is not offered."""
    if not isinstance(item, str):
        return [int(item)] if is_whole(item) and item in offered else []
    match = re.fullmatch(r"([0-9]{1,9})(?:\s*-\s*([0-9]{1,9}))?", item)
    low, high = (int(match[1]), int(match[2] or match[1])) if match else (0, -1)
    both = low in offered and high in offered
    return [number for number in range(low, high + 1) if number in offered] if both else []
