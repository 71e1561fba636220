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

from bench.contract.families import derive
from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, ask_and_tell, settings
from bench.helpers.errors import BenchError


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

    This is the shape of the candidates of LLaMEA and BLADE. They call ``func(x)``, read ``func.bounds.lb`` and ``.ub``,
    and draw from the global random states: these are seeded from the trial's stream, and set back at its end.
    """

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Make an instance of the budget, the dimension and the parameters, and call it with the function."""

        def func(x: ArrayLike) -> object:
            return objective(x)

        vars(func)["bounds"] = SimpleNamespace(lb=objective.lower.copy(), ub=objective.upper.copy())
        states = random.getstate(), np.random.get_state()  # noqa: NPY002
        random.seed(int(rng.integers(1 << 63)))
        np.random.seed(rng.integers(1 << 32, size=4, dtype=np.uint32))  # noqa: NPY002
        try:
            type(self).function(objective.budget, objective.dimension, **settings(self))(func)
        finally:
            random.setstate(states[0])
            np.random.set_state(states[1])  # noqa: NPY002


def shape(plugin: object) -> type[FunctionOptimizer] | None:
    """Return the class of optimizers that a plug-in of one of the three shapes is made one by, None of another one."""
    if not isinstance(plugin, type):
        return FunctionOptimizer if callable(plugin) else None
    if all(callable(getattr(plugin, name, None)) for name in ("ask", "tell")):
        return AskingOptimizer
    is_called = any("__call__" in vars(base) for base in plugin.__mro__)
    return CalledOptimizer if is_called and [*taken(plugin)][:2] == ["budget", "dim"] else None


def taken(function: Callable[..., object]) -> dict[str, inspect.Parameter]:
    """Return what a function or a class takes, by name."""
    try:
        return dict(inspect.signature(function).parameters)
    except (TypeError, ValueError):  # a decorator may leave a signature that cannot be read
        return {}


def class_of(plugin: Any, name: str, load: Callable[..., Optimizer]) -> type[Optimizer]:
    """Return the optimizer class that a plug-in is, or that is made of one of the three shapes.

    What a function or a class takes after its first two arguments becomes parameters.

    Args:
        plugin: a class or a function.
        name: the full name that ``load`` takes, for messages, too.
        load: see :func:`bench.contract.families.derive`.

    Raises:
        BenchError: for anything else, and for arguments that do not begin with the objective and the stream, or that
            have no default.
    """
    if isinstance(plugin, type) and issubclass(plugin, Optimizer):
        return plugin
    base = shape(plugin)
    if base is None:
        raise BenchError(
            f"{name!r} is no optimizer: give a name, a subclass of bench.Optimizer or an instance of one, a function "
            "(objective, rng), a class with ask and tell, or a class X(budget, dim) with __call__(func)"
        )
    arguments = [*taken(plugin).values()]
    keywords, plain = arguments[2:], (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    if len(arguments) < 2 or any(argument.kind not in plain for argument in arguments[:2]):
        raise BenchError(f"{name!r} must take (objective, rng) first, as in def minimize(objective, rng, step=0.1)")
    for argument in keywords:
        if argument.default is argument.empty or argument.kind is inspect.Parameter.POSITIONAL_ONLY:
            raise BenchError(f"parameter {argument.name!r} of {name!r} must be a keyword with a default")
    kinds = {bool: bool, int: int, float: float, str: str}
    parameters = {argument.name: (kinds.get(type(argument.default), Any), argument.default) for argument in keywords}
    doc = inspect.getdoc(plugin) or f"The function {name}."
    return derive(base, name, parameters, load, function=staticmethod(plugin), __doc__=doc)
