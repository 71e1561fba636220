"""Adapt the optimizers of another library: a family of names, their loading, their random numbers and evaluations."""

from __future__ import annotations

import random
import tomllib
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar, Literal

import numpy as np

from bench.contract.families import Parameters, derive
from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, build, parameter
from bench.contract.typing import Floats, Options
from bench.helpers import JsonObject
from bench.helpers.errors import BenchError, nearest, require
from optimizers.common.base import Handling, confine, works

CEILING = 1e100
"""The greatest value given to a library, also for +inf, so that its sums and weights stay finite."""

AGENTS = {"pop_size": "agents", "popsize": "agents", "population_size": "agents"}
"""Parameters of the libraries that have another name here."""


@dataclass(frozen=True)
class Adapter(Optimizer):
    """An algorithm of another library.

    Attributes:
        handling: ``"repair"`` clips the points to the box and applies the problem's own rule before they are evaluated;
            ``"box"`` only clips them. The library goes on from the points it proposed.
    """

    handling: Handling = "repair"

    member: ClassVar[str]  # its name in the library
    own: ClassVar[tuple[str, ...]]  # its parameters that the library takes, by the library's names

    def options(self) -> Options:
        """Return the parameters that the library takes, by its names."""
        return {name: getattr(self, AGENTS.get(name, name)) for name in self.own}

    def values(self, objective: Objective, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points ``x``, which are confined first as ``handling`` says."""
        return np.asarray(objective(confine(objective, x, self.handling)))

    def finite_values(self, objective: Objective, x: Floats) -> Floats:
        """Return :meth:`values` with CEILING in place of greater ones."""
        return np.minimum(self.values(objective, x), CEILING)


@dataclass(frozen=True)
class Constructed(Adapter):
    """An algorithm of another library that is a class whose constructor takes its parameters."""

    solver: ClassVar[Any]  # the library's class

    def __post_init__(self) -> None:
        """Check every parameter, by the library's own rules too; raises BenchError for one that does not fit."""
        super().__post_init__()
        self.construct()

    def construct(self) -> Any:
        """Return the library's object; raises BenchError for parameters that the library refuses."""
        try:
            return self.solver(**self.options())
        except Exception as error:  # the libraries raise AssertionError, ValueError and plain Exception alike
            library, name = self.solver.__module__.partition(".")[0], type(self).__name__
            raise BenchError(f"{library} refuses these parameters of {name}: {error}") from error


def table(family: str) -> JsonObject:
    """Return the facts about a family's library that ``optimizers/<family>.toml`` holds."""
    return tomllib.loads((Path(__file__).parents[1] / f"{family}.toml").read_text(encoding="utf-8"))


def declared(default: object, facts: JsonObject) -> tuple[object, object]:
    """Return type and default of a parameter, by the facts of a table: ``choices``, ``minimum``, ``maximum``.

    A ``kind`` ("int", "float" or "bool") is the type of a parameter whose default is None.
    """
    if "choices" in facts:
        return Literal[tuple(facts["choices"])], default
    kinds: dict[str, object] = {"int": int | None, "float": float | None, "bool": bool | None}
    kind, default = (kinds[facts["kind"]], None) if "kind" in facts else (type(default), default)
    return kind, parameter(default, minimum=facts.get("minimum"), maximum=facts.get("maximum"))


class Family(ABC):
    """A family: the optimizers of one library, behind one entry point.

    Attributes:
        name: the family's name, the first half of ``"mealpy:OriginalGWO"``.
        module: the module to import.
        extra: the optional extra that installs the library, "" for a library that is always installed.
        facts: the family's table (:func:`table`): ``members`` by name, unless the library lists them, and ``left_out``:
            why optimizers of the library are no members, and which: patterns of their names, by reason.
    """

    name: ClassVar[str]
    module: ClassVar[str]
    extra: ClassVar[str] = ""
    facts: ClassVar[JsonObject] = {}

    def __reduce__(self) -> str:
        """Pickle by reference, as ``mealpy`` of optimizers.mealpy: a process then makes each member's class once."""
        return self.name

    def members(self) -> list[str]:
        """Return the library's own names of its optimizers."""
        return list(self.facts["members"])

    @abstractmethod
    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of one of ``members()``; see :func:`bench.contract.families.derive`."""

    def member_class(
        self,
        base: type[Adapter],
        member: str,
        parameters: Parameters,
        keys: Iterable[str],
        *others: str,
        **attributes: object,
    ) -> type[Optimizer]:
        """Return the optimizer class of a member, for ``derive``.

        Args:
            base: the class that implements ``minimize``.
            member: the library's own name of the optimizer.
            parameters: type and default of each parameter, by the library's names.
            keys: of the works that the optimizer cites.
            others: libraries beside the family's own whose code the optimizer runs.
            attributes: further class attributes, which replace those made here.
        """
        libraries = (self.module, *others)
        made = {
            "member": member, "own": tuple(parameters), "bibtex": works(*keys), "libraries": libraries,
            "code": " and ".join(f"{library} {version(library)}" for library in libraries),
        }  # fmt: skip
        renamed = {AGENTS.get(name, name): each for name, each in parameters.items()}
        return derive(base, f"{self.name}:{member}", renamed, self.load, **made | attributes)

    def names(self) -> list[str]:
        """Return the full names of the members; raises BenchError, with the extra to install, for a missing library."""
        self.require()
        return [f"{self.name}:{member}" for member in _members(self)]

    def load(self, name: str, **options: object) -> Optimizer:
        """Return the optimizer of the full name; raises BenchError for an unknown name or parameter."""
        self.require()
        member = name.partition(":")[2]
        if member not in _members(self):
            why = self.why_left_out(member)
            raise BenchError(
                f"{self.name}'s {member} is left out: {why}"
                if why
                else f"{self.name} has no optimizer {member!r}{nearest(member, _members(self))}"
            )
        return build(_derived(self, member), name, options)

    def why_left_out(self, member: str) -> str:
        """Return the reason for which an optimizer of the library is no member, "" for a member or an unknown name."""
        left_out = self.facts.get("left_out", {}).items()
        reasons = (why for why, names in left_out if any(fnmatchcase(member, n) for n in names))
        return next(reasons, "")

    def require(self) -> ModuleType:
        """Return the library's module; raises BenchError, with the extra to install, for a missing library."""
        return require(self.module, self.extra, f"the {self.name} optimizers need")


@cache
def _members(family: Family) -> list[str]:
    return sorted(family.members())


@cache
def _derived(family: Family, member: str) -> type[Optimizer]:
    return family.derive(member)


@contextmanager
def global_random_state(rng: np.random.Generator) -> Iterator[None]:
    """Seed Python's and numpy's global random states from ``rng``, and restore both afterwards.

    Some libraries draw from these states: within a trial they follow the trial's seed, and no other code sees it.
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
