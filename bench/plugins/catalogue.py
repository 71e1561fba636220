"""Describe an installed optimizer: its papers, whose code it is, and its parameters."""

from __future__ import annotations

import dataclasses
import inspect
import types
from dataclasses import dataclass
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from bench.contract.optimizer import Optimizer
from bench.helpers.bibtex import parse
from bench.helpers.errors import BenchError
from bench.plugins import from_file, loading, registry


@dataclass(frozen=True)
class Parameter:
    """A parameter of an optimizer: its default, its type or choices, and the closed range of its values."""

    name: str
    default: object
    kind: str
    minimum: float | None
    maximum: float | None

    def __str__(self) -> str:
        low, high = self.minimum, self.maximum
        span = f"{low} to {high}" if None not in (low, high) else f">= {low}" if low is not None else f"<= {high}"
        bounds = "" if low is None and high is None else f" ({span})"
        return f"{self.name}={self.default!r}{bounds or (f' ({self.kind})' if '|' in self.kind else '')}"


@dataclass(frozen=True)
class Record:
    """An optimizer's lineage and parameters."""

    name: str  # the name that loads it
    family: str  # the family that it is a member of, "" for none
    about: str  # one line on what it is
    paper: list[str]  # authors, year, title and DOI of each work that it implements
    code: str  # whose implementation runs
    parameters: list[Parameter]
    extra: str  # the optional extra of this distribution that it needs, or ""
    unmapped: list[str]  # features of its library that its adapter does not support, one sentence each
    package: str  # the package that offers it


def record(name: str) -> Record:
    """Return the record of the optimizer of that name; raises BenchError where it cannot be loaded."""
    family, colon, _ = name.partition(":")
    installed = from_file.split(name) is None
    kind = type(loading.load_optimizer(name))
    return Record(
        name=name,
        family=family if colon and installed else "",
        about=first_line(kind),
        paper=_papers(kind.bibtex),
        code=kind.code,
        parameters=_parameters(kind),
        extra=str(getattr(registry.load("optimizers", family), "extra", "")) if colon and installed else "",
        unmapped=list(kind.unmapped),
        package=registry.package("optimizers", family) if installed else "",
    )


def first_line(thing: object) -> str:
    """Return the first line of a docstring, or of the help of a typer app, without double backquotes."""
    info = getattr(thing, "info", None)
    return (getattr(info, "help", None) or inspect.getdoc(thing) or "").partition("\n")[0].replace("``", "")


def _papers(bibtex: str) -> list[str]:
    """Return each work as ``Mirjalili et al., 2014, Grey Wolf Optimizer, doi:…``."""
    try:
        works = parse(bibtex)
    except BenchError:
        return []
    return [", ".join(filter(None, (work.author_year, work.title, work.doi and f"doi:{work.doi}"))) for work in works]


def _parameters(kind: type[Optimizer]) -> list[Parameter]:
    hints = get_type_hints(kind)
    parameters = []
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        low, high = field.metadata.get("minimum"), field.metadata.get("maximum")
        parameters.append(Parameter(field.name, field.default, _type_name(hints[field.name]), low, high))
    return parameters


def _type_name(hint: Any) -> str:
    if get_origin(hint) is Literal:
        return " | ".join(repr(choice) for choice in get_args(hint))
    if get_origin(hint) in (Union, types.UnionType):
        return " | ".join(_type_name(option) for option in get_args(hint))
    return "None" if hint is type(None) else str(getattr(hint, "__name__", hint))
