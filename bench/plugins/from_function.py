"""Make an optimizer class of a plain function ``minimize(objective, rng, ...)``."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bench.errors import BenchError
from bench.objective import Objective
from bench.optimizer import Optimizer, settings
from bench.plugins.derived import derive


@dataclass(frozen=True)
class FunctionOptimizer(Optimizer):
    """A plain function ``minimize(objective, rng, …)`` as an optimizer."""

    function: ClassVar[Callable[..., None]]

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Call the function with the parameters as keywords."""
        type(self).function(objective, rng, **settings(self))


def of_function(
    function: Callable[..., Any], name: str, load: Callable[..., Optimizer], **attributes: Any
) -> type[Optimizer]:
    """Return the optimizer class of a function; its arguments after ``objective`` and ``rng`` become parameters.

    Raises:
        BenchError: where the function cannot be called as ``function(objective, rng)``.
    """
    try:
        taken = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        taken = []
    own, plain = taken[2:], (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    if len(taken) < 2 or any(each.kind not in plain for each in taken[:2]):
        raise BenchError(f"{name!r} must take (objective, rng) first, as in def minimize(objective, rng, step=0.1)")
    for each in own:
        if each.default is each.empty or each.kind is inspect.Parameter.POSITIONAL_ONLY:
            raise BenchError(f"parameter {each.name!r} of {name!r} must be a keyword with a default")
    kinds = {bool: bool, int: int, float: float, str: str}
    parameters = {each.name: (kinds.get(type(each.default), Any), each.default) for each in own}
    doc = inspect.getdoc(function) or f"The function {name}."
    return derive(FunctionOptimizer, name, parameters, load, function=staticmethod(function), __doc__=doc, **attributes)
