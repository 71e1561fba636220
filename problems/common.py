"""Problems on a grid of functions, dimensions and instances, for all families of benchmark suites."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from bench import FunctionProblem, Problem, load_problem
from bench.contract.families import Grid, Member
from bench.contract.typing import Options
from bench.helpers.errors import BenchError, nearest


class SuiteProblem(FunctionProblem):
    """A function of a suite; it is pickled as name and options, because compiled objects cannot be pickled."""

    optimum_source = "the definition of the suite"

    compiles = True  # many call compiled code, and none takes long

    def __init__(self, *arguments: Any, options: Options | None = None, **naming: Any) -> None:
        super().__init__(*arguments, vectorized=True, **naming)
        self.evaluate = self._fun  # type: ignore[method-assign] # it takes and returns arrays of float64, see evaluated
        self._load = partial(load_problem, self.name, **(options or {}))

    def __reduce__(self) -> tuple[Callable[[], Problem], tuple[()]]:
        return self._load, ()


def group_of(number: int, groups: Mapping[str, range]) -> str:
    """Return the group that has the function of a number."""
    return next(group for group, numbers in groups.items() if number in numbers)


def features_of(suite: str, member: Member, group: str) -> dict[str, str | int]:
    """Return the features of a suite's problem: suite, function, instance where there is one, and group."""
    instance: dict[str, str | int] = {"instance": member.instance} if member.instance else {}
    return {"suite": suite, "function": member.function, **instance, "group": group}


@dataclass(frozen=True)
class Suite:
    """A family of the problems of a grid.

    Attributes:
        grid: all names; the first instance of each function and dimension is listed.
        make: returns the problem of a name, what the name says, and options.
        options: the options that ``make`` takes.
    """

    grid: Grid
    make: Callable[..., Problem]
    options: tuple[str, ...] = ()

    def names(self) -> list[str]:
        """Return the names that are listed; ``load`` takes other instances, too."""
        return list(self.grid.names(instances=[1]))

    def load(self, name: str, /, **options: Any) -> Problem:
        """Return the problem of that name; raises BenchError where there is none, and for an unknown option."""
        for option in options:
            if option not in self.options:
                raise BenchError(f"problem {name!r} has no option {option!r}{nearest(option, self.options)}")
        return self.make(name, self.grid.member(name), **options)
