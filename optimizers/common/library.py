"""What the families of other libraries' optimizers share: names, parameters, randomness, the way to the objective."""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np

from bench.errors import BenchError, nearest, require
from bench.objective import Objective
from bench.optimizer import Optimizer, build
from bench.problem import Floats
from optimizers.common.bounds import Handling, confine

CEILING = 1e100
"""Given for a greater value, such as +inf, to a library that computes with values: its sums and weights stay finite."""


@dataclass(frozen=True)
class Adapter(Optimizer):
    """An algorithm of another library.

    Attributes:
        handling: what becomes of points before they are evaluated. ``"repair"`` clips them to the box and applies the
            problem's own rule; ``"box"`` only clips them. The library goes on from the points it proposed.
    """

    handling: Handling = "repair"

    def values(self, objective: Objective, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points ``x``, confined as ``handling`` says."""
        values: Floats = objective(confine(objective, x, self.handling))
        return values

    def finite_values(self, objective: Objective, x: Floats) -> Floats:
        """Return :meth:`values`, those above CEILING as CEILING."""
        return np.minimum(self.values(objective, x), CEILING)


class Library(ABC):
    """A family: the optimizers of one library, behind one entry point.

    Attributes:
        name: the family's name, the first half of ``"mealpy:OriginalGWO"``.
        module: the module to import.
        extra: the optional extra that installs the library, "" where it always is.
    """

    name: ClassVar[str]
    module: ClassVar[str]
    extra: ClassVar[str] = ""

    @abstractmethod
    def members(self) -> list[str]:
        """Return the library's own names of its optimizers."""

    @abstractmethod
    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of one of ``members()``; see :func:`bench.plugins.derived.derive`."""

    def names(self) -> list[str]:
        """Return the full names; raises BenchError that names the extra where the library is missing."""
        self.require()
        return [f"{self.name}:{member}" for member in _members(self)]

    def load(self, name: str, **options: Any) -> Optimizer:
        """Return the optimizer of that full name; raises BenchError for an unknown name or parameter."""
        self.require()
        member = name.partition(":")[2]
        if member not in _members(self):
            raise BenchError(f"{self.name} has no optimizer {member!r}{nearest(member, _members(self))}")
        return build(_derived(self, member), name, options)

    def require(self) -> Any:
        """Return the library's module; raises BenchError, naming the extra, where it is missing."""
        return require(self.module, self.extra, f"the {self.name} optimizers need")


@cache
def _members(library: Library) -> list[str]:
    return sorted(library.members())


@cache
def _derived(library: Library, member: str) -> type[Optimizer]:
    return library.derive(member)


@contextmanager
def global_random_state(rng: np.random.Generator) -> Iterator[None]:
    """Seed Python's and numpy's global random states from ``rng``, and put back afterwards what was there.

    Some libraries draw from these states; within a trial they thus follow the trial's seed, and nobody else sees it.
    """
    python, legacy = random.getstate(), np.random.get_state()  # noqa: NPY002
    seed = int(rng.integers(2**32))
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    try:
        yield
    finally:
        random.setstate(python)
        np.random.set_state(legacy)  # noqa: NPY002
