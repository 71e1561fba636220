"""Find which problem and which optimizer of this harness a printed name means."""

from __future__ import annotations

import re
from contextlib import suppress
from functools import cache

from bench.contract.problem import Problem
from bench.formats import naming
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject
from bench.plugins import loading, registry
from bench.reproduce.table import PaperCell, PaperTable, plain


def problem_of(table: PaperTable, cell: PaperCell) -> str:
    """Return the name of the problem that a cell is about; raises BenchError where the table leaves it open."""
    functions: JsonObject = table.settings.get("functions", {})
    if cell.function in functions:
        return str(functions[cell.function])
    if not cell.suite:
        return cell.function
    suites = {plain(name): name for name in registry.entries("problems")}
    suite = suites.get(plain(cell.suite), "")
    if not suite:
        raise BenchError(f"no suite is called {cell.suite!r}{nearest(cell.suite, suites.values())}")
    number = re.fullmatch(r"(?:[a-z]+\d*[-_ ])?[a-z]*[-_ ]?0*(\d+)", cell.function.lower())
    grid = registry.grid(suite)
    if grid is None:
        names = set(registry.load("problems", suite).names())
        stem = [f"{int(number[1]):02d}", number[1]] if number else []
        for name in (*(f"{suite}-{text}" for text in (*stem, cell.function)), cell.function):
            if name in names:
                return name
        raise BenchError(f"{suite} has no problem {cell.function!r}{nearest(cell.function, names)}")
    if cell.dimension is None:
        raise BenchError(f"no dimension is printed, and the functions of {suite} have several")
    titles = {plain(title): name for name, title in grid.titles.items()}
    named = (titles | {plain(name): name for name in grid.functions}).get(plain(cell.function), cell.function)
    function = int(number[1]) if number and named == cell.function else named
    name = naming.problem_name(suite, function, cell.dimension, cell.instance or 1, named)
    grid.member(name)  # raises
    return name


def load_problem(table: PaperTable, cell: PaperCell) -> Problem:
    """Return the problem that a cell is about; raises BenchError where it cannot be loaded."""
    return loading.load_problem(problem_of(table, cell), **table.settings.get("problem", {}))


def optimizer_of(table: PaperTable, printed: str) -> JsonObject:
    """Return name, label and options of the optimizer that a printed name means, as a study has them.

    Raises:
        BenchError: where no optimizer, or none by that name, is known.
    """
    given = table.settings.get("optimizers", {}).get(printed)
    if given is not None:
        chosen = {"name": given} if isinstance(given, str) else dict(given)
        return {"name": printed, "label": printed, **chosen}
    wanted = plain(printed)
    alone, members = _optimizers()
    fitting = [name for name in alone if plain(name) == wanted] or [
        name for name in members if wanted in (plain(name), plain(name.rpartition(":")[2]))
    ]
    if len(fitting) == 1:
        return {"name": fitting[0], "label": printed}
    found = f"{printed!r} may be {' or '.join(fitting)}" if fitting else f"no optimizer is called {printed!r}"
    raise BenchError(f"{found}; name one with --optimizer '{printed}=NAME' ('bench list optimizers')")


@cache
def _optimizers() -> tuple[list[str], list[str]]:
    """Return the names of all optimizers, and of the members of families, whose libraries are imported."""
    alone: list[str] = []
    members: list[str] = []
    for name in registry.entries("optimizers"):
        with suppress(Exception, SystemExit):  # a plug-in may raise anything; another one may have the name
            plugin = registry.load("optimizers", name)
            alone += [] if registry.is_family(plugin) else [name]
            members += plugin.names() if registry.is_family(plugin) else []
    return alone, members
