"""Sweeps: an optimizer with several values of its parameters, one labelled optimizer for each combination.

The label of a combination names its values, as in ``gwo[agents=30,variant=code]``, and is all that marks it as a part
of a sweep: a frozen study, and results that were exported and read again, need no other record.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

from bench.errors import BenchError
from bench.helpers.text import option

MOST = 1_000
"""The largest number of combinations of one sweep: each is an optimizer of the study."""

Levels = tuple[str, ...]


@dataclass(frozen=True)
class Sweep:
    """The combinations of one sweep.

    Attributes:
        name: the label without the values.
        factors: the values of each parameter that was swept, as texts, in their order.
        labels: the optimizer's label of each combination of values.
    """

    name: str
    factors: dict[str, Levels]
    labels: dict[Levels, str]

    @property
    def missing(self) -> list[str]:
        """The labels of the combinations that the study does not hold."""
        names = tuple(self.factors)
        every = product(*self.factors.values())
        return [_label(self.name, zip(names, levels, strict=True)) for levels in every if levels not in self.labels]


def expanded(label: str, fixed: Mapping[str, Any], options: Mapping[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Return label and options of each combination of the values that ``options`` lists; those of ``fixed`` are kept.

    The last list varies fastest. A value that is no list is the same in all combinations and no part of the label.

    Raises:
        BenchError: for an empty list, a value twice, and more than 1,000 combinations.
    """
    swept = {name: value for name, value in options.items() if isinstance(value, list)}
    for name, values in swept.items():
        texts = [option(value) for value in values]
        if not texts or len(set(texts)) < len(texts):
            what = "is empty" if not texts else "holds a value twice"
            raise BenchError(f"the list of values of {name!r} of {label!r} {what}; list each value once")
    if (number := prod(map(len, swept.values()))) > MOST:
        raise BenchError(f"the sweep of {label!r} has {number:,} combinations, more than {MOST:,}; list fewer values")
    kept = {**fixed, **{name: value for name, value in options.items() if name not in swept}}
    combinations = []
    for combination in product(*swept.values()):
        chosen = dict(zip(swept, combination, strict=True))
        pairs = [(name, option(value)) for name, value in chosen.items()]
        combinations.append((_label(label, pairs) if chosen else label, kept | chosen))
    return combinations


def sweeps(optimizers: Iterable[tuple[str, Mapping[str, Any]]]) -> list[Sweep]:
    """Return the sweeps among the optimizers of a study, given as (label, options), in the order of their first ones.

    Labels of a sweep share the name before the bracket and the parameters in it. One combination alone is no sweep.
    """
    labels_by_sweep: dict[tuple[str, Levels], dict[Levels, str]] = {}
    for label, options in optimizers:
        for name, factors, levels in _read(label, options):
            labels_by_sweep.setdefault((name, factors), {})[levels] = label
    every = []
    for (name, factors), labels in labels_by_sweep.items():
        values = {factor: tuple(dict.fromkeys(levels[i] for levels in labels)) for i, factor in enumerate(factors)}
        if len(labels) > 1:
            every.append(Sweep(name, values, labels))
    return every


def _label(name: str, pairs: Iterable[tuple[str, str]]) -> str:
    return f"{name}[{','.join(f'{factor}={level}' for factor, level in pairs)}]"


def _read(label: str, options: Mapping[str, Any]) -> Iterable[tuple[str, Levels, Levels]]:
    """Yield name, parameters and values of a label whose bracket holds the last of the optimizer's own options."""
    pairs = [(name, option(value)) for name, value in options.items()]
    for first in range(len(pairs)):
        bracket = _label("", pairs[first:])
        if label.endswith(bracket) and label != bracket:
            factors, levels = zip(*pairs[first:], strict=True)
            yield label.removesuffix(bracket), factors, levels
            return
