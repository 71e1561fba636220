"""bench list: print the installed plug-ins with their lineage and parameters."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench.cli import completion
from bench.errors import BenchError, nearest
from bench.plugins import registry

KINDS = ("optimizers", "problems", "studies", "commands")


def _kinds(incomplete: str) -> list[str]:
    """Complete a kind or the name of an optimizer, which may be a family."""
    return completion.starting(["all", *KINDS, *registry.entries("optimizers")], incomplete)


def list_plugins(
    kind: Annotated[
        str,
        typer.Argument(
            help="optimizers, problems, studies, commands, all, or a family's name, such as mealpy.",
            autocompletion=_kinds,
        ),
    ] = "all",
    as_json: Annotated[
        bool,
        typer.Option(
            "--json", help="Print JSON records of that kind; of all: the optimizers, families' members included."
        ),
    ] = False,
) -> None:
    """List the installed plug-ins: optimizers with lineage and parameters, problems, studies, commands."""
    if as_json:
        print(json.dumps(records(kind), indent=1, default=str))
    else:
        show(kind, Console())


def show(kind: str, console: Console) -> None:
    """Print the plug-ins of one kind or of all, or a family's optimizers; one that fails to load by its error."""
    families = [] if kind in (*KINDS, "all") else _families()
    _require_known(kind, (*KINDS, "all", *families))
    for each in KINDS if kind == "all" else (kind,):
        table = Table("name", "what it is", title=each, title_justify="left", box=None, pad_edge=False)
        if each in families:
            members = registry.load("optimizers", each).names()
            rows = _shared_lines_first([(name, _describe(_optimizer, name)) for name in members], f"all of {each}")
        else:
            names = sorted(registry.entries(each))
            rows = [(name, _describe(_about, each, name, kind == "optimizers")) for name in names]
        for name, (about, style) in rows:
            table.add_row(Text(name, no_wrap=True), Text(about, style=style))
        console.print(table, "")


def records(kind: str) -> list[dict[str, Any]]:
    """Return the records of the plug-ins of one kind, or of one optimizer or family, as JSON values.

    An optimizer's record is a :class:`bench.plugins.catalogue.Record`, and a family has one record a member; any other
    plug-in has a name, the package that offers it, and a line on what it is. One that fails to load has its error.
    """
    from bench.plugins import catalogue

    installed = registry.entries("optimizers")
    _require_known(kind, (*KINDS, "all", *installed))
    if kind in KINDS and kind != "optimizers":
        return [_plain_record(kind, name) for name in sorted(registry.entries(kind))]
    known: list[dict[str, Any]] = []
    for name in installed if kind in ("optimizers", "all") else [kind]:
        try:
            plugin = registry.load("optimizers", name)
            names = plugin.names() if registry.is_family(plugin) else [name]
        except Exception as error:  # a plug-in may raise anything
            known.append({"name": name, "error": str(error)})
            continue
        for member in names:
            try:
                known.append(dataclasses.asdict(catalogue.record(member)))
            except Exception as error:
                known.append({"name": member, "error": str(error)})
    return known


def _plain_record(kind: str, name: str) -> dict[str, Any]:
    """Return the record of a plug-in that is no optimizer."""
    about, style = _describe(_about, kind, name, False)
    return {"name": name, "package": registry.package(kind, name), "error" if style else "about": about}


def _require_known(kind: str, known: Sequence[str]) -> None:
    if kind not in known:
        raise BenchError(f"unknown kind {kind!r}{nearest(kind, known)}")


def _families() -> list[str]:
    """Return the names of the families of optimizers; to recognise them, all optimizers are imported."""
    names = []
    for name in registry.entries("optimizers"):
        with suppress(BenchError):  # one that fails to load
            names += [name] if registry.is_family(registry.load("optimizers", name)) else []
    return names


def _shared_lines_first(rows: list[tuple[str, tuple[str, str]]], name: str) -> list[tuple[str, tuple[str, str]]]:
    """Move the lines that all rows share into a first row, called ``name``."""
    texts = [about.splitlines() for _, (about, _) in rows]
    shared = [line for line in texts[0] if all(line in text for text in texts)] if len(texts) > 1 else []
    own = ["\n".join(line for line in text if line not in shared) for text in texts]
    members = [(member, (about, style)) for (member, (_, style)), about in zip(rows, own, strict=True)]
    return [(name, ("\n".join(shared), "")), *members] if shared else members


def _describe(describe: Callable[..., str], *arguments: Any) -> tuple[str, str]:
    """Return a description or the error that it raised, and the style to print it in."""
    try:
        return describe(*arguments), ""
    except BenchError as error:
        return str(error), "red"
    except Exception as error:  # a plug-in may raise anything
        return f"failed to load: {error}", "red"


def _about(kind: str, name: str, members: bool) -> str:
    """Describe a plug-in: an optimizer by its lineage and parameters, a family by its members."""
    from bench.plugins import catalogue

    plugin = registry.load(kind, name)
    if kind == "optimizers":
        return _family(name, plugin, members) if registry.is_family(plugin) else _optimizer(name)
    if registry.is_family(plugin):
        names = plugin.names()
        return f"{names[0]} … {names[-1]}" if names else f"{name}:<name>"
    if kind == "studies":
        from bench.study import Study

        return Study.load(name).title
    return catalogue.first_line(plugin)


def _family(name: str, plugin: Any, members: bool) -> str:
    """Describe a family; with ``members``, import its library to name them."""
    from bench.plugins import catalogue

    extra = f"\nextra: {plugin.extra}" if getattr(plugin, "extra", "") else ""
    about = f"{catalogue.first_line(plugin)}\nloaded as {name}:<name>; 'bench list {name}' shows each{extra}"
    if not members:
        return about
    try:
        names = plugin.names()
    except BenchError as error:
        return f"{about}\n{error}"
    return f"{about}\n{len(names)}: {', '.join(names)}"


def _optimizer(name: str) -> str:
    """Describe an optimizer by its lineage and parameters, one line each."""
    from bench.plugins import catalogue

    known = catalogue.record(name)
    lines = [known.about, *(f"paper: {paper}" for paper in known.paper)]
    for title, text in (
        ("code", known.code), ("parameters", ", ".join(map(str, known.parameters))), ("family", known.family),
        ("extra", known.extra), ("package", known.package),
    ):  # fmt: skip
        lines += [f"{title}: {text}"] if text else []
    return "\n".join([*lines, *(f"not mapped: {sentence}" for sentence in known.unmapped)])
