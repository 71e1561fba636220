"""Write a reference page for each command of ``bench``, from the annotations that make its command line."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import typer
from sphinx.application import Sphinx
from typer.models import ArgumentInfo

from extensions.pages import code, plain, table, write


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when the build begins."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "reference" / "commands", pages()))
    return {"parallel_read_safe": True}


def pages() -> dict[str, str]:
    """Return the page of each command, by its name."""
    from bench.cli.app import app
    from bench.plugins import registry

    written = _pages_of(app, "bench")
    for name in registry.entries("commands"):
        command = registry.load("commands", name)
        if isinstance(command, typer.Typer):
            written[name] = _group(command, f"bench {name}")
        elif name not in written:
            written[name] = page(f"bench {name}", command)
    return written


def _pages_of(app: typer.Typer, program: str, level: int = 1) -> dict[str, str]:
    groups = {str(each.name): _group(each.typer_instance, f"{program} {each.name}") for each in app.registered_groups}
    commands = {str(each.name or each.callback.__name__): each.callback for each in app.registered_commands}
    return {name: page(f"{program} {name}", command, level) for name, command in commands.items()} | groups


def _group(app: typer.Typer | None, name: str) -> str:
    assert app is not None
    about = app.info.help or (app.registered_callback and inspect.getdoc(app.registered_callback.callback)) or ""
    return "\n\n".join([f"# {name}", plain(about), *_pages_of(app, name, 2).values()])


def page(name: str, command: Callable[..., Any], level: int = 1) -> str:
    """Return the page of one command: its docstring, arguments and options."""
    hints = get_type_hints(command, include_extras=True)
    arguments, options = [], []
    for parameter in inspect.signature(command).parameters.values():
        kind, info = _split(hints[parameter.name])
        if isinstance(info, ArgumentInfo):
            shown = info.metavar or parameter.name
            many = "…" if get_origin(kind) is list and not shown.endswith("…") else ""
            optional = parameter.default is not parameter.empty
            arguments.append((f"[{shown}{many}]" if optional else f"{shown}{many}", plain(info.help or "")))
        else:
            options.append(_option(parameter, kind, info))
    text = (inspect.getdoc(command) or "").partition("\n\nArgs:")[0]
    usage = " ".join([name, *(shown for shown, _ in arguments), *(["[OPTIONS]"] if options else [])])
    parts = [f"{'#' * level} {name}", *(plain(each) for each in text.split("\n\n")), f"```text\n{usage}\n```"]
    if arguments:
        parts.append(table(("argument", "meaning"), [(code(shown), about) for shown, about in arguments]))
    if options:
        parts.append(table(("option", "meaning", "default"), options))
    return "\n\n".join(parts) + "\n"


def _split(hint: Any) -> tuple[Any, Any]:
    """Return a parameter's type without None, and what typer knows of it."""
    kind, *extras = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    (given,) = (
        [each for each in get_args(kind) if each is not type(None)][:1] if type(None) in get_args(kind) else [kind]
    )
    return given, extras[0] if extras else typer.Option()


def _option(parameter: inspect.Parameter, kind: Any, info: Any) -> tuple[str, str, str]:
    flag = kind is bool
    given = (info.default, *(info.param_decls or ()))  # typer has the first of several names as the default
    names = " / ".join(name for name in given if isinstance(name, str) and name.startswith("-"))
    if not names:
        long = parameter.name.strip("_").replace("_", "-")
        names = f"--{long} / --no-{long}" if flag else f"--{long}"
    item = get_args(kind)[0] if get_origin(kind) is list else kind
    value = "" if flag else " " + (info.metavar or {str: "TEXT", int: "N", float: "X"}.get(item, "PATH"))
    default = parameter.default
    hidden = default is None or default is parameter.empty or default is ... or (flag and not default)
    return code(names + value), plain(info.help or ""), "" if hidden else code("on" if default is True else default)
