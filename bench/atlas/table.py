"""The table of an atlas: the implementations of each method, their parameters, and their documented differences.

Tables are TOML files. Packages offer them by the entry-point group ``bench.atlases``; a user gives a file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bench.errors import BenchError, nearest
from bench.helpers.parsing import parse_toml, read_text
from bench.numbers import is_whole
from bench.plugins import registry
from bench.plugins.loading import default_label, package

GENERATION = 30  # evaluations of a generation where a method does not say


@dataclass(frozen=True)
class Implementation:
    """One implementation of a method.

    Attributes:
        method: the name of the method.
        label: its name on the page of the method.
        name: the optimizer's name, such as ``"mealpy:OriginalGWO"``.
        options: its parameters.
        differs: what is documented of its differences, in sentences.
        source: where that is documented.
    """

    method: str
    label: str
    name: str
    options: Mapping[str, Any] = field(default_factory=dict)
    differs: str = ""
    source: str = ""

    @property
    def key(self) -> str:
        """Its name in the whole atlas."""
        return f"{self.method} {self.label}"

    @property
    def library(self) -> str:
        """The family, the file or the installed package that it comes from."""
        return Path(package(self.name)).name.partition(" ")[0]


@dataclass(frozen=True)
class Method:
    """A method and its implementations.

    Attributes:
        name: its name, which is that of its page.
        title: its name in words.
        conditions: which parameters are the same in all implementations, in words.
        generation: the evaluations of its first generation.
        implementations: all of them, the one to compare others with first.
        technical: parameters that are meant to change no result, such as a number of threads.
    """

    name: str
    title: str
    conditions: str
    generation: int
    implementations: tuple[Implementation, ...]
    technical: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raise BenchError where two implementations have one label."""
        labels = [implementation.label for implementation in self.implementations]
        for label in labels:
            if labels.count(label) > 1:
                raise BenchError(
                    f"two implementations of the method {self.name!r} are called {label!r}; give one another label"
                )

    def joined(self, other: Method) -> Method:
        """Return this method with the implementations of both."""
        technical = tuple(dict.fromkeys((*self.technical, *other.technical)))
        return replace(self, implementations=(*self.implementations, *other.implementations), technical=technical)


def methods(file: Path | None = None, names: Sequence[str] = ()) -> list[Method]:
    """Return the methods of the installed tables, or those of a file with what the installed tables add to them.

    Args:
        file: a table; its methods alone are returned.
        names: the methods to return, all by default.

    Raises:
        BenchError: for a table that cannot be read, and for an unknown method.
    """
    sources = {
        f"the table {name!r} of bench.atlases": registry.load("atlases", name) for name in registry.entries("atlases")
    }
    by_name: dict[str, Method] = {}
    of_source: list[Method] = []
    for where, source in [*sources.items(), *([(str(file), file)] if file is not None else [])]:
        of_source = _read(source, where)
        for method in of_source:
            by_name[method.name] = by_name[method.name].joined(method) if method.name in by_name else method
    if file is not None:
        by_name = {method.name: by_name[method.name] for method in of_source}
    for name in names:
        if name not in by_name:
            raise BenchError(f"the atlas has no method {name!r}{nearest(name, by_name)}")
    chosen = [by_name[name] for name in dict.fromkeys(names)] if names else list(by_name.values())
    if not chosen:
        raise BenchError("no installed package has a table of methods (bench.atlases); give a file")
    return chosen


def parse(text: str, where: str) -> list[Method]:
    """Return the methods of a table's text; raises BenchError, naming ``where``, for a text that is none."""
    try:
        tables = parse_toml(text)
    except ValueError as error:
        raise BenchError(f"{where} is no TOML: {error}") from error
    _check(tables, {"technical": list, "methods": dict}, f"{where}:", required="methods")
    technical = tuple(map(str, tables.get("technical", ())))
    return [_method(name, method, technical, where) for name, method in tables["methods"].items()]


def _read(source: Any, where: str) -> list[Method]:
    """Return the methods of a file, or of a resource of a package."""
    try:
        text = read_text(source) if isinstance(source, Path) else source.read_text(encoding="utf-8")
    except (AttributeError, OSError, ValueError) as error:
        raise BenchError(f"{where} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    return parse(text, where)


def _method(name: str, table: Any, technical: tuple[str, ...], where: str) -> Method:
    here = f"method {name!r} in {where}"
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name) or name in ("index", "times", "readme"):
        raise BenchError(f"{here} must have a name of small letters, digits and hyphens that is no other page's")
    kinds = {"title": str, "conditions": str, "generation": int, "implementations": list}
    _check(table, kinds, here, required="implementations")
    settings = {"title": "", "conditions": "", "generation": GENERATION} | table
    if not settings["implementations"]:
        raise BenchError(f"{here} has no implementation")
    generation = settings["generation"]
    if not is_whole(generation) or generation < 1:
        raise BenchError(f"{here} has a generation of {generation!r}; it must be a whole number of at least 1")
    kinds = {"name": str, "label": str, "options": dict, "differs": str, "source": str}
    for entry in settings["implementations"]:
        _check(entry, kinds, f"an implementation of {here}", required="name")
    made = [
        Implementation(name, **entry | {"label": entry.get("label") or default_label(entry["name"])})
        for entry in settings["implementations"]
    ]
    settings["title"] = settings["title"] or name
    return Method(name, **settings | {"implementations": tuple(made)}, technical=technical)


def _check(table: Any, kinds: Mapping[str, type], here: str, required: str) -> None:
    """Raise BenchError for a table that lacks a key, or has an unknown one or a value of another kind."""
    words = {str: "a text", int: "a whole number", list: "a list", dict: "a table"}
    if not isinstance(table, dict):
        raise BenchError(f"{here} must be a table, not {table!r}")
    for key, value in table.items():
        if key not in kinds:
            raise BenchError(f"{here} has an unknown key {key!r}{nearest(key, kinds)}")
        if not isinstance(value, kinds[key]):
            raise BenchError(f"{here} has {key} = {value!r}, which must be {words[kinds[key]]}")
    if required not in table:
        raise BenchError(f"{here} lacks the key {required!r}")
