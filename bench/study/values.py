"""The values of a study that have a class, and the fields that hold them: each is read and checked in one place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar, cast

T = TypeVar("T")


@dataclass(frozen=True, eq=False, repr=False)
class Value:
    """A value of a study. It equals, and is shown as, the plain value that a study's file has for it.

    Attributes:
        plain: the value as a study's file has it: a number, a text, a list or a table.
    """

    plain: object

    def __eq__(self, other: object) -> bool:
        return bool(self.plain == (other.plain if isinstance(other, Value) else other))

    def __hash__(self) -> int:
        return hash(self.plain) if isinstance(self.plain, int | float | str) else hash(type(self))

    def __repr__(self) -> str:
        return repr(self.plain)


class Checked(Generic[T]):
    """A field of a dataclass that holds the value its reader returns for a given one, such as a plain value.

    The default is not read. A reader takes a value and the subject of a sentence about it, and raises BenchError.
    """

    def __init__(self, read: Callable[[object, str], T], default: T | None = None) -> None:
        self.read, self.default, self.name = read, default, ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, instance: object, owner: type) -> T:
        return cast("T", self.default if instance is None else instance.__dict__[self.name])

    def __set__(self, instance: object, value: object) -> None:
        instance.__dict__[self.name] = value if value is self.default else self.read(value, f"'{self.name}'")
