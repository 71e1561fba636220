"""What the families of benchmark suites share: problems on a grid of functions, dimensions and instances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bench import FunctionProblem, Problem, load_problem
from bench.errors import BenchError
from bench.grid import Grid, Member


class SuiteProblem(FunctionProblem):
    """A function of a suite; it is pickled as its name, because compiled objects cannot be pickled."""

    def __reduce__(self) -> tuple[Callable[[str], Problem], tuple[str]]:
        return load_problem, (self.name,)


@dataclass(frozen=True)
class Suite:
    """A family of the problems of a grid.

    Attributes:
        grid: all names; the first instance of each function and dimension is listed.
        make: returns the problem of a name and what the name says.
    """

    grid: Grid
    make: Callable[[str, Member], Problem]

    def names(self) -> list[str]:
        """Return the names that are listed; ``load`` takes other instances, too."""
        return list(self.grid.names(instances=[1]))

    def load(self, name: str, /, **options: Any) -> Problem:
        """Return the problem of that name; raises BenchError where there is none, and for any option."""
        for option in options:
            raise BenchError(f"problem {name!r} has no options, and so no {option!r}")
        return self.make(name, self.grid.member(name))
