"""bench list: print the installed plug-ins, one optimizer with its lineage and parameters."""

from __future__ import annotations

import dataclasses
import inspect
import json
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from bench.cli.console import table
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject
from bench.plugins import catalogue, registry
from bench.study import Study

Entry = JsonObject
"""A plug-in as JSON has it: its name, and what it is (``about`` or ``title``) or the ``error`` that it raised."""

KINDS = ("optimizers", "problems", "studies", "commands")
GROUPED = ("optimizers", "problems")
"""The kinds of which one family, suite or plug-in can be listed."""

ARCHIVES = "archives"
"""The published data sets of a suite, which are no plug-ins."""


def command(
    kind: Annotated[
        str,
        typer.Argument(
            help="optimizers, problems, studies, commands, archives, all, or the name of an optimizer, a family or a "
            "suite, such as mealpy.",
        ),
    ] = "all",
    family: Annotated[
        str,
        typer.Argument(
            help="Of optimizers, problems or archives: one family or suite alone, as in 'problems cec2022'.",
            show_default=False,
        ),
    ] = "",
    search: Annotated[
        str, typer.Option(help="Print what has this text in its name or description, installed or not.")
    ] = "",
    as_json: Annotated[
        bool,
        typer.Option(
            "--json", help="Print JSON records of that kind; of all: the optimizers, families' members included."
        ),
    ] = False,
) -> None:
    """List the installed plug-ins: optimizers, problems, studies, commands.

    Of one kind, each has a line; of one suite, all functions are listed with their dimensions and instances, of one
    family all members, and of one optimizer its papers, code and parameters. 'archives' are the data sets of COCO's
    archive that 'bench import' gets, those of bbob or of another suite.
    """
    kind, family = _chosen(kind, family)
    console = Console()
    if search or as_json:
        listed = _matching(search, kind, family) if search else records(kind, family)
        if as_json:
            print(json.dumps(listed, indent=1, default=str))
        else:
            _print(f"with {search!r}", listed, console)
    elif kind == "all":
        for group in KINDS:
            console.print(Text(f"{group}: {', '.join(sorted(registry.entries(group)))}"), "")
        console.print(
            Text("'bench list KIND' or NAME describes them, '--search TEXT' finds one by name or description.")
        )
    elif kind == "problems" and family:
        _print_suite(family, console)
    elif kind == "optimizers" and family:
        _print_optimizers(family, console)
    elif kind == ARCHIVES:
        _print(f"{kind} of {family}", records(kind, family), console)
    else:
        _print(kind, [{"name": name} | _tried(_about, kind, name) for name in sorted(registry.entries(kind))], console)


def _matching(text: str, kind: str, family: str) -> list[Entry]:
    """Return the records that have a text; raises BenchError where none has."""
    suites = [family] if family else list(registry.entries("problems"))
    matching = [
        record
        for group in (KINDS if kind == "all" else (kind,))
        for part in (suites if group == "problems" else [family])
        for record in records(group, part)
        if text.lower() in f"{record['name']} {_words(record)}".lower()
    ]
    if not matching:
        raise BenchError(f"no plug-in has {text!r} in its name or description")
    return matching


def _words(entry: Entry) -> str:
    return str(entry.get("error") or entry.get("title") or entry.get("about", ""))


def _chosen(kind: str, family: str) -> tuple[str, str]:
    """Return the kind and the family, "" for all, of the words of a command; a name alone has a kind."""
    if kind == ARCHIVES:
        return kind, family or "bbob"
    if not family and kind not in (*KINDS, "all"):
        of = kind.partition(":")[0]
        kind, family = next((group for group in GROUPED if of in registry.entries(group)), kind), kind
    named = [name for group in GROUPED for name in registry.entries(group)]
    _require_known("no kind, family, suite or plug-in is called", kind, (*KINDS, ARCHIVES, "all", *named))
    if family and kind not in GROUPED:
        raise BenchError(f"{kind!r} has no families or suites; leave out {family!r}")
    if family:
        of = family.partition(":")[0] if kind == "optimizers" else family
        _require_known(f"unknown family of {kind}", of, registry.entries(kind))
    return kind, family


def _require_known(what: str, name: str, names: Iterable[str]) -> None:
    if name not in names:
        raise BenchError(f"{what} {name!r}{nearest(name, names)}")


def _print(title: str, entries: Iterable[Entry], console: Console) -> None:
    """Print a table of names and what they are, or why they do not load."""
    rows = [
        (Text(entry["name"], no_wrap=True), Text(_words(entry), "red" if "error" in entry else "")) for entry in entries
    ]
    console.print(table(("name", "what it is"), rows, title=title), "")


def _print_optimizers(name: str, console: Console) -> None:
    """Print the members of a family of optimizers, or the papers, code and parameters of one optimizer."""
    plugin = None if ":" in name else registry.load("optimizers", name)
    if plugin is None or not registry.is_family(plugin):
        found = catalogue.record(name)
        parts = (
            *(("paper", paper) for paper in found.paper), ("code", found.code),
            ("parameters", ", ".join(map(str, found.parameters))), ("extra", found.extra), ("package", found.package),
            *(("not mapped", sentence) for sentence in found.unmapped),
        )  # fmt: skip
        console.print(table(("", ""), [(name, found.about), *(part for part in parts if part[1])]))
    elif plugin.names():
        _print(name, _optimizer_records(name), console)
    else:
        for paragraph in (inspect.getdoc(plugin) or f"{name} has no list of its members").split("\n\n"):
            console.print(Text(" ".join(paragraph.replace("``", "").split())))


def _print_suite(family: str, console: Console) -> None:
    """Print a suite's functions with their dimensions, or the names of another family of problems."""
    grid, listed = registry.grid(family), _problem_records(family)
    columns = {"name": [record["name"] for record in listed]}
    if grid:
        columns = {
            "function": [*grid.functions],
            "what it is": [record["title"] for record in listed if grid.titles],
            "dimensions": [", ".join(map(str, dimensions)) for dimensions in grid.functions.values()],
            "instances": [f"1 to {grid.instances}" for _ in listed if grid.instances],
            "first name": columns["name"],
        }
    shown = {head: cells for head, cells in columns.items() if cells}
    console.print(table([*shown], zip(*shown.values(), strict=True), title=family), "")
    try:  # to load one, which may need an extra
        if grid:
            registry.load("problems", family).load(next(grid.names(instances=[1])))
    except BenchError as error:
        console.print(Text(str(error), style="red"))


def records(kind: str, family: str = "") -> list[Entry]:
    """Return the records of the plug-ins of one kind, or of one family of it, as JSON values.

    An optimizer's record is a :class:`bench.plugins.catalogue.Record`, and a family has one record a member; any other
    plug-in has a name, the package that offers it, and a line on what it is. One that fails to load has its error. Of
    one suite there is a record a function, with its dimensions and the first of its names; of another family of
    problems, a record with each name that can be listed. Of the archives of a suite, a record has a data set.
    """
    if family and kind == "problems":
        return _problem_records(family)
    if kind == ARCHIVES:
        return _archive_records(family)
    if kind in KINDS and kind != "optimizers":
        return [
            {"name": name, "package": registry.package(kind, name)} | _tried(_about, kind, name)
            for name in sorted(registry.entries(kind))
        ]
    names = [family] if family else registry.entries("optimizers")
    return [entry for name in names for entry in _optimizer_records(name)]


def _optimizer_records(name: str) -> list[Entry]:
    """Return the record of an optimizer or of each member of a family; without its library, of those it knows."""
    try:
        plugin = None if ":" in name else registry.load("optimizers", name)
        names = [name] if plugin is None or not registry.is_family(plugin) else plugin.names()
    except Exception as error:  # a plug-in may raise anything
        known = [name]
        with suppress(Exception):
            known = [f"{name}:{member}" for member in registry.load("optimizers", name).members()]
        return [{"name": member, "error": str(error)} for member in known]
    found = {member: _tried(catalogue.record, member) for member in names}
    return [
        {"name": member} | (each if "error" in each else dataclasses.asdict(each["about"]))
        for member, each in found.items()
    ]


def _problem_records(family: str) -> list[Entry]:
    grid = registry.grid(family)
    if grid is None:
        return [{"name": name} for name in registry.load("problems", family).names() or [f"{family}:<name>"]]
    return [
        {
            "function": function, "dimensions": list(dimensions), "instances": grid.instances,
            "name": next(grid.names([function])), "title": grid.titles.get(function, ""),
        }
        for function, dimensions in grid.functions.items()
    ]  # fmt: skip


def _archive_records(suite: str) -> list[Entry]:
    from bench.formats.coco.published import data_folder, data_sets

    kept = data_folder()
    return [
        {
            "name": f"coco:{data.name}", "megabytes": data.kilobytes / 1000,
            "about": f"{data.kilobytes / 1000:.1f} MB" + ", kept" * (kept / data.suite / data.path).is_file(),
        }
        for data in data_sets(suite)
    ]  # fmt: skip


def _tried(describe: Callable[..., object], *arguments: object) -> Entry:
    """Describe a plug-in by a function, or by the error that this raises."""
    try:
        return {"about": describe(*arguments)}
    except Exception as error:  # a plug-in may raise anything
        return {"error": str(error) if isinstance(error, BenchError) else f"failed to load: {error}"}


def _about(kind: str, name: str) -> str:
    """Return a line on a plug-in: the title of a study, the first and the last name of a family of problems, …"""
    plugin = registry.load(kind, name)
    if kind == "studies":
        return Study.load(name).title
    if not registry.is_family(plugin):
        return catalogue.record(name).about if kind == "optimizers" else catalogue.first_line(plugin)
    if kind == "optimizers":
        return catalogue.first_line(plugin)
    names = plugin.names()
    return f"{names[0]} … {names[-1]}" if names else f"{name}:<name>"
