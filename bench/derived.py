"""Optimizer classes made at run time: from a plain function, or from an algorithm of another library."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from bench.errors import BenchError
from bench.objective import Objective
from bench.optimizer import Optimizer, settings

Parameters = Mapping[str, tuple[Any, Any]]
"""Type and default, or :func:`bench.parameter`, of each parameter by name."""


def derive(base: type[Optimizer], name: str, parameters: Parameters, **attributes: Any) -> type[Optimizer]:
    """Return a frozen dataclass of optimizers that adds ``parameters`` and class attributes to ``base``.

    Such a class has no module that a worker could import it from: its instances pickle as their plug-in's ``name``
    and options, and are loaded again by these.

    Args:
        base: the class that implements ``minimize``.
        name: the full name that ``load_optimizer`` takes, such as ``"mealpy:OriginalGWO"``.
        parameters: what is added to the parameters of ``base``; one of the same name replaces it.
        attributes: class attributes, such as ``bibtex`` and ``code``.
    """
    fields = [(key, kind, value) for key, (kind, value) in parameters.items()]
    namespace = {"plugin": name, "__reduce__": _reduce, **attributes}
    title = name.rpartition(":")[2]
    made: type[Optimizer] = dataclasses.make_dataclass(title, fields, bases=(base,), namespace=namespace, frozen=True)
    return made


def _reduce(self: Any) -> tuple[Callable[..., Optimizer], tuple[str, dict[str, Any]]]:
    return _reload, (self.plugin, settings(self))


def _reload(name: str, options: dict[str, Any]) -> Optimizer:
    from bench.plugins import load_optimizer

    return load_optimizer(name, **options)


@dataclasses.dataclass(frozen=True)
class FunctionOptimizer(Optimizer):
    """A plain function ``minimize(objective, rng, …)`` as an optimizer."""

    function: ClassVar[Callable[..., None]]

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Call the function with the parameters as keywords."""
        type(self).function(objective, rng, **settings(self))


def of_function(function: Callable[..., Any], name: str, **attributes: Any) -> type[Optimizer]:
    """Return the optimizer class of a function; what it takes after ``objective`` and ``rng`` are its parameters.

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
    return derive(FunctionOptimizer, name, parameters, function=staticmethod(function), __doc__=doc, **attributes)
