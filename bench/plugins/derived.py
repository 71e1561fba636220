"""Create optimizer classes at run time: for a function, a class in a file, or an algorithm of another library."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bench.optimizer import Optimizer, settings

Parameters = Mapping[str, tuple[Any, Any]]
"""Type and default, or :func:`bench.parameter`, of each parameter by name."""


def derive(
    base: type[Optimizer], name: str, parameters: Parameters, load: Callable[..., Optimizer], **attributes: Any
) -> type[Optimizer]:
    """Return a frozen dataclass of optimizers that adds ``parameters`` and class attributes to ``base``.

    Another process cannot import such a class, so its instances are pickled as ``load``, name and options, and loaded
    again from these.

    Args:
        base: the class that implements ``minimize``.
        name: the full name that ``load`` takes, such as ``"mealpy:OriginalGWO"``.
        parameters: the parameters to add to those of ``base``; one of the same name replaces it.
        load: an importable ``load(name, **options)`` that returns an instance.
        attributes: class attributes, such as ``bibtex`` and ``code``.
    """

    def reduce(self: Any) -> tuple[Callable[[], Optimizer], tuple[()]]:
        return partial(load, name, **settings(self)), ()

    fields = [(key, kind, value) for key, (kind, value) in parameters.items()]
    namespace = {"plugin": name, "__reduce__": reduce, **attributes}
    title = name.rpartition(":")[2]
    made: type[Optimizer] = dataclasses.make_dataclass(title, fields, bases=(base,), namespace=namespace, frozen=True)
    return made
