"""Make an optimizer class of a plain function, or of a class that asks and tells."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

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


def asks_and_tells(plugin: object) -> bool:
    """Return whether it is a class with the methods ``ask`` and ``tell``."""
    return isinstance(plugin, type) and all(callable(getattr(plugin, name, None)) for name in ("ask", "tell"))


def optimizer_of(function: Callable[..., Any], name: str, load: Callable[..., Optimizer]) -> type[Optimizer]:
    """Return the optimizer class of a function, or of a class that asks and tells.

    What it takes after ``objective`` and ``rng`` becomes parameters.

    Args:
        function: the function or the class.
        name: the full name that ``load`` takes, for messages, too.
        load: see :func:`bench.families.derive`.

    Raises:
        BenchError: for arguments that do not begin with the objective and the stream, or that have no default.
    """
    try:
        taken = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):  # a decorator may leave a signature that cannot be read
        taken = []
    keywords, plain = taken[2:], (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    if len(taken) < 2 or any(argument.kind not in plain for argument in taken[:2]):
        raise BenchError(f"{name!r} must take (objective, rng) first, as in def minimize(objective, rng, step=0.1)")
    for argument in keywords:
        if argument.default is argument.empty or argument.kind is inspect.Parameter.POSITIONAL_ONLY:
            raise BenchError(f"parameter {argument.name!r} of {name!r} must be a keyword with a default")
    kinds = {bool: bool, int: int, float: float, str: str}
    parameters = {argument.name: (kinds.get(type(argument.default), Any), argument.default) for argument in keywords}
    base = AskingOptimizer if asks_and_tells(function) else FunctionOptimizer
    doc = inspect.getdoc(function) or f"The function {name}."
    return derive(base, name, parameters, load, function=staticmethod(function), __doc__=doc)
