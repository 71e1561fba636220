"""Make an optimizer class of a plain function, of a class that asks and tells, or of one that takes budget and dim."""

from __future__ import annotations

import inspect
import random
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from bench.errors import BenchError
from bench.families import derive
from bench.objective import Objective
from bench.optimizer import Optimizer, ask_and_tell, settings


@dataclass(frozen=True)
class FunctionOptimizer(Optimizer):
    """A plain function ``minimize(objective, rng, …)`` as an optimizer."""

    function: ClassVar[Callable[..., Any]]

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Call the function with the parameters as keywords."""
        type(self).function(objective, rng, **settings(self))


@dataclass(frozen=True)
class AskingOptimizer(FunctionOptimizer):
    """A class whose instances, one a trial, propose points and learn their values, as an optimizer."""

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Make an instance of the objective, the stream and the parameters, and ask and tell it."""
        ask_and_tell(type(self).function(objective, rng, **settings(self)), objective, self.minimum_budget)


@dataclass(frozen=True)
class CalledOptimizer(FunctionOptimizer):
    """A class ``X(budget, dim)`` whose instances, one a trial, are called with the function, as an optimizer.

    This is the shape of the candidates of LLaMEA and BLADE, which draw from the global random states: these are seeded
    from the trial's stream, and set back at its end.
    """

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Make an instance of the budget, the dimension and the parameters, and call it with the function."""
        states = random.getstate(), np.random.get_state()  # noqa: NPY002
        random.seed(int(rng.integers(1 << 63)))
        np.random.seed(rng.integers(1 << 32, size=4, dtype=np.uint32))  # noqa: NPY002
        try:
            search = type(self).function(objective.budget, objective.dimension, **settings(self))
            search(CalledFunction(objective))
        finally:
            random.setstate(states[0])
            np.random.set_state(states[1])  # noqa: NPY002


class CalledFunction:
    """The objective as such an instance takes it: ``func(x)``, and ``func.bounds.lb`` and ``.ub``."""

    def __init__(self, objective: Objective) -> None:
        self.bounds = SimpleNamespace(lb=objective.lower.copy(), ub=objective.upper.copy())
        self._objective = objective

    def __call__(self, x: ArrayLike) -> Any:
        """Return the value of a point, or the values of several; raises BudgetExhausted once the budget is spent."""
        return self._objective(x)


def is_loose(plugin: object) -> bool:
    """Return whether :func:`optimizer_of` takes it: a function, or a class of one of two shapes."""
    return callable(plugin) and (not isinstance(plugin, type) or asks_and_tells(plugin) or takes_budget(plugin))


def takes_budget(plugin: object) -> bool:
    """Return whether it is a class ``X(budget, dim)`` whose instances can be called."""
    if not isinstance(plugin, type) or not any("__call__" in vars(base) for base in plugin.__mro__):
        return False
    return [argument.name for argument in _taken(plugin)[:2]] == ["budget", "dim"]


def asks_and_tells(plugin: object) -> bool:
    """Return whether it is a class with the methods ``ask`` and ``tell``."""
    return isinstance(plugin, type) and all(callable(getattr(plugin, name, None)) for name in ("ask", "tell"))


def optimizer_of(function: Callable[..., Any], name: str, load: Callable[..., Optimizer]) -> type[Optimizer]:
    """Return the optimizer class of a function, of a class that asks and tells, or of a class ``X(budget, dim)``.

    What it takes after its first two arguments becomes parameters.

    Args:
        function: the function or the class.
        name: the full name that ``load`` takes, for messages, too.
        load: see :func:`bench.families.derive`.

    Raises:
        BenchError: for arguments that do not begin with the objective and the stream, or that have no default.
    """
    taken = _taken(function)
    keywords, plain = taken[2:], (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    if len(taken) < 2 or any(argument.kind not in plain for argument in taken[:2]):
        raise BenchError(f"{name!r} must take (objective, rng) first, as in def minimize(objective, rng, step=0.1)")
    for argument in keywords:
        if argument.default is argument.empty or argument.kind is inspect.Parameter.POSITIONAL_ONLY:
            raise BenchError(f"parameter {argument.name!r} of {name!r} must be a keyword with a default")
    kinds = {bool: bool, int: int, float: float, str: str}
    parameters = {argument.name: (kinds.get(type(argument.default), Any), argument.default) for argument in keywords}
    base = FunctionOptimizer
    if isinstance(function, type):
        base = AskingOptimizer if asks_and_tells(function) else CalledOptimizer
    doc = inspect.getdoc(function) or f"The function {name}."
    return derive(base, name, parameters, load, function=staticmethod(function), __doc__=doc)


def _taken(function: Callable[..., Any]) -> list[inspect.Parameter]:
    try:
        return list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):  # a decorator may leave a signature that cannot be read
        return []
