"""The table of an atlas: which implementations each method has, with which parameters, and what is known of them.

Tables are TOML files. Packages offer them by the entry-point group ``bench.atlases``; a user gives a file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
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


def methods(file: Path | None = None, names: Sequence[str] = ()) -> list[Method]:
    """Return the methods of the installed tables, or those of a file with what the installed tables add to them.

    Args:
        file: a table; its methods alone are returned.
        names: the methods to return, all by default.

    Raises:
        BenchError: for a table that cannot be read, and for an unknown method.
    """
    given = [] if file is None else _read(file)
    found: dict[str, Method] = {}
    for method in [*(each for name in registry.entries("atlases") for each in _installed(name)), *given]:
        found[method.name] = _joined(found[method.name], method) if method.name in found else method
    if file is not None:
        found = {each.name: found[each.name] for each in given}
    for name in names:
        if name not in found:
            raise BenchError(f"the atlas has no method {name!r}{nearest(name, found)}")
    chosen = [found[name] for name in dict.fromkeys(names)] if names else list(found.values())
    if not chosen:
        raise BenchError("no installed package has a table of methods (bench.atlases); give a file")
    return chosen


def parse(text: str, where: str) -> list[Method]:
    """Return the methods of a table's text; raises BenchError, naming ``where``, for a text that is none."""
    try:
        tables = parse_toml(text)
    except ValueError as error:
        raise BenchError(f"{where} is no TOML: {error}") from error
    whole = _entries(tables, {"technical": list, "methods": dict}, f"{where}:", required=("methods",))
    technical = tuple(map(str, whole["technical"] or ()))
    return [replace(_method(name, each, where), technical=technical) for name, each in whole["methods"].items()]


def _installed(name: str) -> list[Method]:
    found = registry.load("atlases", name)
    try:
        text = found.read_text(encoding="utf-8")
    except (AttributeError, OSError, ValueError) as error:
        raise BenchError(f"the table {name!r} of bench.atlases is no file that can be read: {error}") from error
    return parse(text, f"the table {name!r} of bench.atlases")


def _read(file: Path) -> list[Method]:
    try:
        text = read_text(file)
    except OSError as error:
        raise BenchError(f"{file} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise BenchError(f"{file} cannot be read: {error}") from error
    return parse(text, str(file))


def _method(name: str, table: Any, where: str) -> Method:
    here = f"method {name!r} in {where}"
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name) or name in ("index", "times", "readme"):
        raise BenchError(f"{here} must have a name of small letters, digits and hyphens that is no other page's")
    own = _entries(
        table, {"title": str, "conditions": str, "generation": int, "implementations": list}, here,
        required=("implementations",),
    )  # fmt: skip
    if not own["implementations"]:
        raise BenchError(f"{here} has no implementation")
    generation = GENERATION if own["generation"] is None else own["generation"]
    if not is_whole(generation) or generation < 1:
        raise BenchError(f"{here} has a generation of {generation!r}; it must be a whole number of at least 1")
    made = [_implementation(name, each, here) for each in own["implementations"]]
    _refuse_twins(made)
    return Method(name, own["title"] or name, own["conditions"] or "", generation, tuple(made))


def _implementation(method: str, table: Any, here: str) -> Implementation:
    kinds = {"name": str, "label": str, "options": dict, "differs": str, "source": str}
    own = _entries(table, kinds, f"an implementation of {here}", required=("name",))
    label = own["label"] or default_label(own["name"])
    return Implementation(
        method, label, own["name"], own["options"] or {}, own["differs"] or "", own["source"] or ""
    )  # fmt: skip


def _entries(table: Any, kinds: Mapping[str, type], here: str, required: Iterable[str]) -> dict[str, Any]:
    """Return the entries of a table, None for those it lacks; raises BenchError for others and for other kinds."""
    words = {str: "a text", int: "a whole number", list: "a list", dict: "a table"}
    if not isinstance(table, dict):
        raise BenchError(f"{here} must be a table, not {table!r}")
    for key, value in table.items():
        if key not in kinds:
            raise BenchError(f"{here} has an unknown key {key!r}{nearest(key, kinds)}")
        if not isinstance(value, kinds[key]):
            raise BenchError(f"{here} has {key} = {value!r}, which must be {words[kinds[key]]}")
    for key in required:
        if key not in table:
            raise BenchError(f"{here} lacks the key {key!r}")
    return {key: table.get(key) for key in kinds}


def _joined(first: Method, second: Method) -> Method:
    """Return the first method with the implementations of both."""
    implementations = (*first.implementations, *second.implementations)
    _refuse_twins(implementations)
    technical = tuple(dict.fromkeys((*first.technical, *second.technical)))
    return replace(first, implementations=implementations, technical=technical)


def _refuse_twins(implementations: Sequence[Implementation]) -> None:
    labels = [each.label for each in implementations]
    for each in implementations:
        if labels.count(each.label) > 1:
            raise BenchError(
                f"two implementations of the method {each.method!r} are called {each.label!r}; give one another label"
            )
