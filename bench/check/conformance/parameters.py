"""Rule of the parameters: typed fields with defaults, checked on construction."""

from __future__ import annotations

import dataclasses
import inspect
import types
from collections.abc import Iterator
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from bench.check.conformance.recording import ViolationError
from bench.check.conformance.subject import Subject
from bench.contract.optimizer import Optimizer, is_frozen
from bench.helpers.errors import BenchError
from bench.helpers.text import count
from bench.sandbox.messages import describe_error


def check_parameters(subject: Subject) -> str:
    """Fields of a frozen dataclass, with types and defaults, all of them checked on construction."""
    source = subject.source
    cls: type[Optimizer] = source if isinstance(source, type) else type(subject.fresh())
    if not is_frozen(cls):
        raise ViolationError(f"{cls.__name__} is no frozen dataclass", "put @dataclass(frozen=True) above the class")
    if cls.__abstractmethods__:
        raise ViolationError("it has no method minimize", "write minimize(self, objective, rng)")
    fields = dataclasses.fields(cls)  # type: ignore[arg-type]
    names = [field.name for field in fields]
    for base in (base for base in cls.__mro__ if base is not Optimizer):
        for name, kind in inspect.get_annotations(base).items():
            if name not in names and not name.startswith("_") and "ClassVar" not in str(kind):
                raise ViolationError(
                    f"{name!r} of {base.__name__} looks like a parameter but is none",
                    f"put @dataclass(frozen=True) above {base.__name__} too, or annotate {name!r} as a ClassVar",
                )
    for field in fields:
        if field.init and field.default is field.default_factory is dataclasses.MISSING:
            raise ViolationError(f"its parameter {field.name!r} has no default", "give every parameter a default")
    cls()
    for name, wrong in _wrong_values(cls, [field.name for field in fields if field.init]):
        try:
            cls(**{name: wrong})
        except BenchError:
            continue
        except Exception as error:
            raise ViolationError(
                f"a wrong {name!r} raises {describe_error(error)} instead of a BenchError",
                "call super().__post_init__() before anything else in __post_init__",
            ) from error
        if name == "agents" and isinstance(wrong, int):
            raise ViolationError(
                f"it takes agents={wrong}",
                "declare it as agents: int = bench.parameter(30, minimum=1), with the least population that the method "
                "works with as the minimum, such as 4 for DE/rand/1",
            )
        raise ViolationError(
            f"it takes anything as {name!r}, whatever its declared type",
            "call super().__post_init__() in __post_init__: it checks every parameter",
        )
    optimizer: Any = subject.fresh()
    least = next((field.metadata.get("minimum") for field in fields if field.name == "agents"), None)
    if least is not None:
        try:
            subject.run(instance=dataclasses.replace(optimizer, agents=int(least)))
        except Exception as error:
            raise ViolationError(
                f"it fails with agents={least}, the least population that it declares: {describe_error(error)}",
                "declare the least population that the method works with as the minimum",
            ) from error
    population = "" if least is None else f"; its population is at least {least}"
    return f"{count(len(fields), 'parameter')} with defaults, and wrong values are refused{population}"


def _wrong_values(cls: type[Optimizer], names: list[str]) -> Iterator[tuple[str, object]]:
    """Yield values that do not fit a parameter's declared type, and population sizes below 1."""
    hints = get_type_hints(cls)
    for name in names:
        if _is_plain(hints[name]):
            yield name, object()
        if name == "agents":
            yield from ((name, 0), (name, -1))


def _is_plain(hint: object) -> bool:
    if get_origin(hint) in (Union, types.UnionType):
        return all(_is_plain(alternative) for alternative in get_args(hint))
    return get_origin(hint) is Literal or hint in (int, float, bool, str, type(None))
