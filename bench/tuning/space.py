"""The space of a tuning: what each parameter of an optimizer may be, read from its declaration."""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from bench.errors import BenchError
from bench.optimizer import CONDITIONS, Optimizer

AGENTS = 5, 300
"""What is tried of a population size that declares no range, on a logarithmic scale: below 5 a generation hardly shows
a landscape, and 300, the thesis's, is ten times what most authors use."""

WIDE = 1e3  # the ratio of the ends of a range without a declared scale, from which on it is searched logarithmically


@dataclass(frozen=True)
class Axis:
    """An axis of the search space, a parameter: a closed range of numbers, or choices where ``choices`` holds any.

    ``default`` is None where the optimizer chooses the value itself; the first configuration then leaves it out.
    """

    name: str
    default: Any
    whole: bool = False
    low: float = 0.0
    high: float = 0.0
    log: bool = False
    choices: tuple[Any, ...] = ()

    def suggest(self, trial: Any) -> Any:
        """Return optuna's suggestion for a trial."""
        if self.choices:
            return trial.suggest_categorical(self.name, list(self.choices))
        suggest = trial.suggest_int if self.whole else trial.suggest_float
        return suggest(self.name, self.low, self.high, log=self.log)

    def as_dict(self) -> dict[str, Any]:
        """Return the axis as a table of the record."""
        return (
            {"choices": list(self.choices)} if self.choices else {"low": self.low, "high": self.high, "log": self.log}
        )

    def __str__(self) -> str:
        if self.choices:
            return f"{self.name} {' | '.join(map(str, self.choices))}"
        return f"{self.name} {self.low:g} to {self.high:g}{' (log)' if self.log else ''}"


def space(
    name: str, optimizer: Optimizer, fixed: Collection[str], budget: int, conditions: Collection[str] = ()
) -> list[Axis]:
    """Return the axis of each parameter of an optimizer but those ``fixed``.

    The conditions of a comparison (:data:`bench.optimizer.CONDITIONS`) are tried only where ``conditions`` names them:
    an optimizer that is tuned in them meets the others under conditions of its own.

    Args:
        name: the optimizer's name in messages.
        optimizer: its defaults.
        fixed: the parameters that keep the value they were given.
        budget: the smallest budget of a run, which no population may exceed.
        conditions: the conditions that are tuned, too.

    Raises:
        BenchError: where a range is none or leaves what the optimizer accepts, and where nothing can be tuned.
    """
    hints = get_type_hints(type(optimizer))
    axes: list[Axis] = []
    left: list[Axis] = []  # conditions that nobody asked for
    for field in dataclasses.fields(optimizer):  # type: ignore[arg-type]
        if field.name in fixed or not field.init:
            continue
        axis = _axis(f"parameter {field.name!r} of {name!r}", field, list(_kinds(hints[field.name])), budget)
        if axis is not None:
            (left if field.name in CONDITIONS and field.name not in conditions else axes).append(axis)
    if not axes:
        more = f", or ask for a condition, as in --condition {left[0].name}" if left else ""
        raise BenchError(
            f"{name!r} has no parameter to tune; declare a range, as in bench.parameter(0.5, tune=(0.1, 1)){more}"
        )
    return axes


def _axis(where: str, field: dataclasses.Field[Any], kinds: list[Any], budget: int) -> Axis | None:
    tune, low, high = (field.metadata.get(key) for key in ("tune", "minimum", "maximum"))
    numbers = [kind for kind in kinds if kind in (int, float)]
    if isinstance(tune, list) or (tune is None and not numbers):
        return _choices(where, field, [value for kind in kinds for value in _values(kind)] if tune is None else tune)
    log = bool(field.metadata.get("log"))
    if tune is not None:
        ends = tune
    elif field.name == "agents":
        ends, log = (max(AGENTS[0], low or 1), AGENTS[1]), True
    elif low is None or high is None:
        return None
    else:
        ends, log = (low, high), log or bool(low > 0 and high >= WIDE * low)
    try:
        ends = tuple(float(end) for end in ends)
        first, last = ends
    except (TypeError, ValueError) as error:
        raise BenchError(f"the tuning range of {where} must be two numbers, such as (0.1, 1), not {tune!r}") from error
    if field.name == "agents":
        last = min(last, float(budget))
    if not (math.isfinite(first) and math.isfinite(last) and first < last):
        raise BenchError(f"the tuning range of {where} is none: {first:g} to {last:g}; its low end must be the smaller")
    if log and first <= 0:
        raise BenchError(f"the tuning range of {where} begins at {first:g}; a logarithmic one must begin above 0")
    if (low is not None and first < low) or (high is not None and last > high):
        raise BenchError(f"the tuning range of {where}, {first:g} to {last:g}, exceeds the values that it accepts")
    default = field.default if isinstance(field.default, (int, float)) else None
    if default is not None:  # the first configuration must lie in the space
        first, last = min(first, default), max(last, default)
    whole = int in numbers and float not in numbers
    if whole:
        first, last = int(first), int(last)
    return Axis(field.name, default, whole, first, last, log and first > 0)


def _choices(where: str, field: dataclasses.Field[Any], values: list[Any]) -> Axis | None:
    """Return an axis of choices; None where there is no choice, as for texts, and for an empty list."""
    if not all(isinstance(value, (bool, int, float, str)) for value in values):
        raise BenchError(f"the values to tune of {where} must be numbers, texts, or true and false, not {values!r}")
    values = list(dict.fromkeys(values))
    if not values:
        return None
    if isinstance(field.default, (bool, int, float, str)) and field.default not in values:
        values.append(field.default)
    if len(values) < 2:
        raise BenchError(f"the only value to tune of {where} is {values[0]!r}; list two or more, or none")
    default = field.default if field.default in values else None
    return Axis(field.name, default, choices=tuple(values))


def _kinds(hint: Any) -> Iterator[Any]:
    """Yield the kinds of a union, or the hint itself; None is left out."""
    if get_origin(hint) in (Union, types.UnionType):
        for kind in get_args(hint):
            yield from _kinds(kind)
    elif hint is not type(None):
        yield hint


def _values(kind: Any) -> tuple[Any, ...]:
    """Return the values of a kind that has few; None is none that a study can hold."""
    if kind is bool:
        return (False, True)
    return tuple(value for value in get_args(kind) if value is not None) if get_origin(kind) is Literal else ()
