"""Write a reference page for each command of ``bench``, with what its ``--help`` prints."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from typer.main import get_command

from extensions.pages import code, plain, table, write

LISTED = re.compile(r"<list\[(\w+)\]>")  # the type of what may be given several times, as its meaning says


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when the build begins."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "reference" / "commands", pages()))
    return {"parallel_read_safe": True}


def pages() -> dict[str, str]:
    """Return the page of each command, plug-ins' included, by its name."""
    from bench.cli.app import add_plugins, app

    add_plugins()
    commands: dict[str, Any] = get_command(app).commands  # type: ignore[attr-defined]
    return {name: page(f"bench {name}", command) for name, command in commands.items()}


def page(name: str, command: Any, level: int = 1) -> str:
    """Return the page of a command: its help, usage, arguments and options, and those of its own commands."""
    context = command.context_class(command, info_name=name)
    usage = " ".join([name, *command.collect_usage_pieces(context)])
    parts = [f"{'#' * level} {name}", *map(plain, (command.help or "").split("\n\n")), f"```text\n{usage}\n```"]
    for kind in ("argument", "option"):
        records = [each.get_help_record(context) for each in command.params if each.param_type_name == kind]
        if rows := [(code(LISTED.sub(r"<\1>", shown)), plain(about)) for shown, about in filter(None, records)]:
            parts.append(table((kind, "meaning"), rows))
    parts += [page(f"{name} {each.name}", each, level + 1) for each in getattr(command, "commands", {}).values()]
    return "\n\n".join(parts) + "\n"
