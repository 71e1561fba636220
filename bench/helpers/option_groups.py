"""Let a command take its options in groups.

To typer, this command has the parameters ``output`` and ``months``; it is called with a ``Wear``::

    class Wear(OptionGroup, panel="Wear"):
        months: int | None = option(help="…")

    @grouped
    def simulate(output: Path, *, wear: Wear) -> None: ...
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, dataclass_transform

import typer
from typer.models import OptionInfo


def option(default: Any = None, *names: str, **settings: Any) -> Any:
    """Return an option for a field of a group; the arguments are those of ``typer.Option``."""
    return typer.Option(default, *names, **settings)


@dataclass_transform(frozen_default=True)
class OptionGroup:
    """A frozen dataclass whose fields are options, which the help shows in its panel; a grouped command makes it."""

    def __init_subclass__(cls, panel: str | None = None) -> None:
        dataclass(frozen=True)(cls)
        for default in vars(cls).values():
            if isinstance(default, OptionInfo):
                default.rich_help_panel = panel


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with the fields of each group in place of it; raises ValueError for a name that comes twice."""
    parameters = signature(command, eval_str=True).parameters.values()
    groups: dict[str, Any] = {each.name: each.annotation for each in parameters if is_dataclass(each.annotation)}
    flat: list[Parameter] = []
    for each in parameters:
        flat += signature(each.annotation, eval_str=True).parameters.values() if each.name in groups else [each]

    @wraps(command)
    def called(**values: Any) -> None:
        made = {}
        for name, group in groups.items():
            made[name] = group(**{each.name: values.pop(each.name) for each in fields(group)})
        command(**values, **made)

    called.__annotations__ = {each.name: each.annotation for each in flat}
    vars(called)["__signature__"] = Signature([each.replace(kind=Parameter.KEYWORD_ONLY) for each in flat])
    return called
