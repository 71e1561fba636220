"""The contract of an optimizer: its parameters and its search."""

from __future__ import annotations

import dataclasses
import types
from abc import ABC, abstractmethod
from functools import lru_cache
from inspect import signature
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from bench.contract.typing import Options
from bench.helpers.errors import BenchError, nearest

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from bench.contract.objective import Objective
    from bench.contract.typing import Floats


T = TypeVar("T")

CONDITIONS = ("agents", "handling", "start")
"""Parameters, or class attributes, that mean the same in all optimizers that have them; reports compare them.

The population size; what becomes of a point outside the box or the constraints; and where the search starts, which is
``"random"`` for points of ``objective.initial``.
"""


def parameter(default: T, *, minimum: float | None = None, maximum: float | None = None) -> T:
    """Return a dataclass field with a default, and the range that its value must lie in.

    Args:
        default: the value where none is given.
        minimum: the least value that is accepted; None for no limit.
        maximum: the greatest one, likewise.
    """
    limits = {"minimum": minimum, "maximum": maximum}
    return dataclasses.field(default=default, metadata=limits)  # which stands for its value


class Optimizer(ABC):
    """A population or trajectory method; subclasses are frozen dataclasses whose fields are their parameters.

    A parameter is declared as a field with a type (``int``, ``float``, ``bool``, ``str``, ``Literal[…]`` or a union
    with None) and a default, with :func:`parameter` where it has a range; its value is checked on construction.
    A field ``agents`` is the population size, and a trial's budget must suffice for one generation of it. Reports
    compare it, ``handling`` and ``start`` (:data:`CONDITIONS`) among the optimizers that have them.

    Attributes:
        bibtex: BibTeX of the publications that introduced the method; reports cite them. Its TeX may
            be letters, fonts and formulas only.
        code: whose implementation runs, such as ``"the cma package"``.
        unmapped: one sentence for each feature of another library's algorithm that its adapter cannot reproduce.
        libraries: the distributions whose versions decide its trials, besides the package of the class, such as
            ``("cma",)`` for a wrapper of pycma.
        invariances: the changes of a problem under which a run is the same: some of "translation", "scale", "monotone"
            and "budget", which ``bench check`` tests.
    """

    bibtex: ClassVar[str] = ""
    code: ClassVar[str] = ""
    unmapped: ClassVar[tuple[str, ...]] = ()
    libraries: ClassVar[tuple[str, ...]] = ()
    invariances: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        """Check every parameter; raises BenchError naming the first that does not fit."""
        hints = _hints(type(self))
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            _check(type(self).__name__, field, hints[field.name], getattr(self, field.name))

    @abstractmethod
    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent, seeing only ``objective`` and drawing only from ``rng``.

        The call may loop forever: ``objective`` raises BudgetExhausted when the budget ends, and the harness keeps
        the best point. An optimizer that stops by a criterion of its own declares it with ``objective.stop(reason)``.
        """

    @property
    def minimum_budget(self) -> int:
        """The evaluations that one generation takes, which are the population size, or 1 without one."""
        return int(getattr(self, "agents", None) or 1)

    def check_budget(self, budget: int, label: str) -> None:
        """Raise BenchError, naming the optimizer by ``label``, for a budget below one generation."""
        if budget < self.minimum_budget:
            raise BenchError(
                f"a budget of {budget} evaluations is below one generation of {label!r}, which takes "
                f"{self.minimum_budget}; raise the budget or lower its agents"
            )


class Search(Protocol):
    """The state of a trial that proposes points and learns from their values."""

    def ask(self, n: int, /) -> ArrayLike:
        """Return (n, d) points to evaluate; more or fewer than ``n``, its ``agents`` or 1, are evaluated, too."""

    def tell(self, x: Floats, f: Floats, /) -> object:
        """Learn the (n,) values ``f`` of the (n, d) points ``x`` that were asked last."""


class AskTell(Optimizer):
    """A method that proposes points and learns from their values; its loop is given.

    The parameters are its own, as of every optimizer; the state of a trial is the object that :meth:`start` returns.
    """

    @abstractmethod
    def start(self, objective: Objective, rng: np.random.Generator) -> Search:
        """Return the state of a trial, any object with ``ask(n)`` and ``tell(x, f)`` (:class:`Search`).

        ``objective`` has the box, ``initial`` and ``repair``.
        """

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Ask and tell until the budget is spent."""
        ask_and_tell(self.start(objective, rng), objective, self.minimum_budget)


def ask_and_tell(search: Search, objective: Objective, n: int) -> None:
    """Ask for ``n`` points and tell their values until the budget is spent.

    Where ``ask`` takes ``x0``, it is asked first with the (k, d) points that are known before the search, if any are.
    """
    if len(objective.x0) and "x0" in signature(search.ask).parameters:
        x = np.array(search.ask(n, x0=objective.handed_out(len(objective.x0))), dtype=np.float64, ndmin=2)  # type: ignore[call-arg]
        search.tell(x, objective(x))
    while True:
        x = np.array(search.ask(n), dtype=np.float64, ndmin=2)
        search.tell(x, objective(x))


def settings(optimizer: Optimizer) -> Options:
    """Return the values of an optimizer's parameters, by name."""
    return {field.name: getattr(optimizer, field.name) for field in dataclasses.fields(optimizer)}  # type: ignore[arg-type]


def defaults(optimizer: Optimizer) -> Options:
    """Return the defaults of an optimizer's parameters, by name, without a parameter that has none."""
    values = {}
    for field in dataclasses.fields(optimizer):  # type: ignore[arg-type]
        if field.default is not dataclasses.MISSING:
            values[field.name] = field.default
        elif field.default_factory is not dataclasses.MISSING:
            values[field.name] = field.default_factory()
    return values


def is_frozen(cls: type) -> bool:
    """Return whether the class is a frozen dataclass."""
    return bool(getattr(getattr(cls, "__dataclass_params__", None), "frozen", False))


def build(cls: type[Optimizer], name: str, options: Options) -> Optimizer:
    """Return ``cls(**options)``; raises BenchError for an option that is no parameter, naming the nearest one."""
    if not is_frozen(cls) or getattr(cls, "__abstractmethods__", None):
        raise BenchError(f"optimizer {name!r} ({cls.__name__}) must be a frozen dataclass that implements minimize")
    parameters = {field.name for field in dataclasses.fields(cls) if field.init}  # type: ignore[arg-type]
    for option in options:
        if option not in parameters:
            raise BenchError(f"optimizer {name!r} has no parameter {option!r}{nearest(option, parameters)}")
    try:
        return cls(**options)
    except TypeError as error:
        raise BenchError(f"optimizer {name!r} cannot be made: {error}; give its parameters defaults") from error


_hints = lru_cache(maxsize=512)(get_type_hints)
"""Return the types of a class's fields; cached, because their evaluation takes longer than a short trial."""


def _check(owner: str, field: dataclasses.Field[object], hint: object, value: object) -> None:
    """Raise BenchError unless ``value`` is of the hinted type and inside the field's range."""
    where = f"parameter {field.name!r} of {owner}"
    if not _fits(hint, value):
        sweep = f"; to sweep it, write options = {{ {field.name} = […] }}" if isinstance(value, list) else ""
        raise BenchError(f"{where} must be {_spell(hint)}, not {value!r}{sweep}")
    low, high = field.metadata.get("minimum"), field.metadata.get("maximum")
    if value is None or (low is None and high is None):
        return
    if not (low is None or value >= low) or not (high is None or value <= high):  # written so that NaN is refused
        wanted = f"at least {low}" if high is None else f"at most {high}" if low is None else f"from {low} to {high}"
        raise BenchError(f"{where} must be {wanted}, not {value!r}")


def _fits(hint: object, value: object) -> bool:
    if hint is Any:  # a class since Python 3.11
        return True
    if get_origin(hint) is Literal:
        return value in get_args(hint)
    if get_origin(hint) in (Union, types.UnionType):
        return any(_fits(option, value) for option in get_args(hint))
    if hint is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    if hint is int:
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, hint) if isinstance(hint, type) else True


def _spell(hint: object) -> str:
    if get_origin(hint) is Literal:
        return "one of " + ", ".join(repr(choice) for choice in get_args(hint))
    if get_origin(hint) in (Union, types.UnionType):
        return " or ".join(_spell(option) for option in get_args(hint))
    names = {int: "a whole number", float: "a number", bool: "true or false", str: "a text", type(None): "nothing"}
    return names.get(hint, str(hint)) if isinstance(hint, type) else str(hint)
