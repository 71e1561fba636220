"""Print what the results of a folder say now, whichever command asks.

Nothing of :mod:`bench.report` is imported where a report of the same trials has noted it, as that would take seconds.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.text import Text

from bench.cli.console import table
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError
from bench.helpers.parsing import parse_json, read_text
from bench.storage.folder import ANSWER, Folder

OLD = "the report is older than the trials; write it again: bench report {}"


def read(folder: Path) -> dict[str, Any]:
    """Return the answer of the report in a folder; empty where there is none that can be read."""
    try:
        content = parse_json(read_text(folder / ANSWER))
        return content if isinstance(content, dict) and isinstance(content.get("rows"), list) else {}
    except (OSError, ValueError):
        return {}


def is_old(folder: Path) -> bool:
    """Return whether the report in a folder is of other trials than the folder holds now."""
    noted = read(folder)  # one with settings of its own has no state
    return bool(noted) and noted.get("state") not in ("", Folder(folder).store.state())


def show(folder: Path, console: Console) -> None:
    """Print what :class:`bench.Results` says of a folder now, and whether its report is older."""
    try:
        content, old = read(folder), is_old(folder)
        if old or not content.get("state"):
            from bench.comparison.notebook import Results

            content = Results(folder).answer
    except BenchError as error:
        print_line(f"nothing can be said of the results: {error}", "yellow", console)
        return
    console.print(as_lines(content))
    if old:
        print_line(OLD.format(folder), "yellow", console)


def as_lines(content: dict[str, Any]) -> Group:
    """Return an answer as lines for a terminal."""
    parts: list[RenderableType] = [Text(str(content.get("sentence", "")), style="bold")]
    parts += [Text(f"{label}: {text}") for label, text in content.get("lines", [])]
    if content.get("selection"):
        parts.append(Text(str(content["selection"])))
    if content["rows"]:
        parts += [Text(), table([*map(str, content["columns"])], content["rows"], right=True)]
    if content.get("more"):
        parts.append(Text(str(content["more"])))
    return Group(*parts)
