"""Other values of an optimizer's parameters, with which a run is repeated to see whether a parameter is idle."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, Literal, get_args, get_origin, get_type_hints

from bench.contract.optimizer import CONDITIONS, Optimizer


def alternatives(optimizer: Optimizer) -> dict[str, list[object]]:
    """Return other values of each parameter of an optimizer but the conditions, up to four.

    They are the other choices; of a number, the ends of its range, twice and half of it, and the next whole numbers.
    """
    hints = get_type_hints(type(optimizer))
    alternatives_of = {}
    for parameter in fields(optimizer):  # type: ignore[arg-type]
        if parameter.name in CONDITIONS or not parameter.init:
            continue
        now, hint = getattr(optimizer, parameter.name), hints[parameter.name]
        if isinstance(now, bool):
            values: list[Any] = [not now]
        elif get_origin(hint) is Literal:
            values = [choice for choice in get_args(hint) if choice is not None]
        elif isinstance(now, int | float):
            ends = [parameter.metadata.get(end) for end in ("minimum", "maximum")]
            values = [2 * now, now / 2, *(end for end in ends if end is not None), now + 1, now - 1]
            if isinstance(now, int) and hint is not float:
                values = [int(value) for value in values]
        else:
            continue
        values = [value for value in dict.fromkeys(values) if value != now]
        if accepted := [value for value in values if _accepted(optimizer, parameter.name, value)]:
            alternatives_of[parameter.name] = accepted[:4]
    return alternatives_of


def _accepted(optimizer: Optimizer, name: str, value: object) -> bool:
    try:
        replace(optimizer, **{name: value})  # type: ignore[type-var]
    except Exception:  # a plug-in checks its parameters as it likes
        return False
    return True
