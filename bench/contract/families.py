"""Families of plug-ins: the names of a suite's problems, and classes of optimizers that are made when they are loaded.

The problems of a suite are functions in dimensions and instances, with names such as ``bbob-f08-d10-i1``.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

from bench.contract.numbers import require_whole
from bench.contract.optimizer import Optimizer, settings
from bench.helpers.errors import BenchError, nearest

LARGEST_INSTANCE = 200_000
"""BBOB's generator is seeded with 10,000 times the instance, which must stay below its modulus, 2^31 - 1."""


class Member(NamedTuple):
    """The parts of a suite problem's name; ``instance`` is 0 where the suite has no instances."""

    function: str
    dimension: int
    instance: int


def dimension_in(name: str) -> int | None:
    """Return the dimension that a name of this form has, as in ``bbob-f08-d10-i1``, None for another name."""
    match = re.search(r"-d([1-9][0-9]{0,6})(?:-i[0-9]+)?$", name)
    return int(match[1]) if match else None


def function_of(name: str) -> str:
    """Return the name of a problem without its instance: ``"bbob-f08-d5"`` of ``"bbob-f08-d5-i1"``."""
    before, mark, instance = name.rpartition("-i")
    return before if mark and instance.isdigit() else name


@dataclass(frozen=True)
class Grid:
    """The problems of a suite by function, dimension and instance.

    A family of problems with an attribute ``grid`` offers all of it: its ``load`` is called for every name that begins
    with the family's, patterns such as ``bbob-f*-d5-*`` match the grid's names, and a study may select from it by
    ``suite``, ``functions``, ``dimensions`` and ``instances``.

    Attributes:
        suite: the name of the family.
        functions: the dimensions of each function, by the function's name: ``{"f01": (2, 3, 5), …}``.
        instances: the instances that patterns and studies take by default, from 1; a name may have any from 1 to
            200,000. With 0, the suite has no instances, and names end with the dimension.
        titles: what functions are called, by the function's name: ``{"f01": "sphere", …}``; some may have none.
    """

    suite: str
    functions: Mapping[str, Sequence[int]]
    instances: int = 0
    titles: Mapping[str, str] = field(default_factory=dict)

    @property
    def dimensions(self) -> list[int]:
        """All dimensions, ascending; some functions may have a part of them only."""
        return sorted({dimension for dimensions in self.functions.values() for dimension in dimensions})

    def names(
        self,
        functions: Iterable[str] | None = None,
        dimensions: Container[int] | None = None,
        instances: Iterable[int] | None = None,
    ) -> Iterator[str]:
        """Yield the names of some functions, dimensions and instances; by default all functions and dimensions.

        A function is left out in the dimensions that it does not have.
        """
        numbers = list(range(1, self.instances + 1) if instances is None else instances)
        for function in self.functions if functions is None else functions:
            for dimension in self.functions[function]:
                if dimensions is None or dimension in dimensions:
                    stem = f"{self.suite}-{function}-d{dimension}"
                    yield from (f"{stem}-i{number}" for number in numbers) if self.instances else (stem,)

    def member(self, name: str) -> Member:
        """Return the parts of a problem's name; raises BenchError where it names no problem of this suite."""
        instance = "-i(0|[1-9][0-9]{0,17})" if self.instances else "()"
        match = re.fullmatch(rf"{re.escape(self.suite)}-(.+)-d(0|[1-9][0-9]{{0,17}}){instance}", name)
        if match is None:
            example = next(self.names())
            raise BenchError(f"unknown problem {name!r}; the problems of {self.suite} have names such as {example!r}")
        function, dimension, number = match[1], int(match[2]), int(match[3] or 0)
        if function not in self.functions:
            raise BenchError(f"{self.suite} has no function {function!r}{nearest_function(function, self.functions)}")
        if dimension not in self.functions[function]:
            dimensions = ", ".join(map(str, self.functions[function]))
            raise BenchError(f"{function} of {self.suite} has no dimension {dimension}; it has {dimensions}")
        if self.instances:
            require_whole(f"the instance of {name!r}", number, 1, LARGEST_INSTANCE)
        return Member(function, dimension, number)


def nearest_function(function: str, known: Iterable[str]) -> str:
    """Return a hint at the functions that there are: the first and last number, or the nearest names."""
    names = list(known)
    if all(re.fullmatch(r"f\d+", name) for name in names):
        gaps = sorted(set(range(int(names[0][1:]), int(names[-1][1:]) + 1)) - {int(name[1:]) for name in names})
        without = f" without {', '.join(f'f{gap:02d}' for gap in gaps)}" if gaps else ""
        return f"; it has {names[0]} to {names[-1]}{without}"
    return nearest(function, names)


Parameters = Mapping[str, tuple[object, object]]
"""Type and default, or :func:`bench.parameter`, of each parameter by name."""


def derive(
    base: type[Optimizer], name: str, parameters: Parameters, load: Callable[..., Optimizer], **attributes: object
) -> type[Optimizer]:
    """Return a frozen dataclass of optimizers that adds ``parameters`` and class attributes to ``base``.

    Another process cannot import such a class, so its instances are pickled as ``load``, name and options, and loaded
    again from these.

    Args:
        base: the class that implements ``minimize``.
        name: the full name that ``load`` takes, such as ``"mealpy:OriginalGWO"``.
        parameters: the parameters to add to those of ``base``; one of the same name replaces it.
        load: an importable ``load(name, **options)`` that returns an instance.
        attributes: class attributes, such as ``bibtex`` and ``code``.
    """

    def reduce(self: Optimizer) -> tuple[Callable[[], Optimizer], tuple[()]]:
        return partial(load, name, **settings(self)), ()

    fields = [(key, kind, value) for key, (kind, value) in parameters.items()]
    namespace = {"plugin": name, "__reduce__": reduce, **attributes}
    title = name.rpartition(":")[2]
    made: type[Optimizer] = dataclasses.make_dataclass(title, fields, bases=(base,), namespace=namespace, frozen=True)
    return made
