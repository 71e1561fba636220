"""Print what the results of a folder say now, whichever command asks.

Nothing of :mod:`bench.report` is imported where a report of the same trials has noted it, as that would take seconds.
"""

from __future__ import annotations

from pathlib import Path

from rich.console import Console, Group, RenderableType
from rich.text import Text

from bench.cli.console import table
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject, parse_json, read_text
from bench.storage.folder import ANSWER, Folder


def read(folder: Path) -> JsonObject:
    """Return the answer of the report in a folder; empty where there is none that can be read."""
    try:
        content = parse_json(read_text(folder / ANSWER))
        return content if isinstance(content, dict) and isinstance(content.get("rows"), list) else {}
    except (OSError, ValueError):
        return {}


def show(folder: Path, console: Console) -> None:
    """Print what :class:`bench.Results` says of a folder now, and whether its report is older."""
    content = noted = read(folder)
    try:
        if noted.get("state") != Folder(folder).store.state():
            from bench.comparison.notebook import Results

            content = Results(folder).answer
    except BenchError as error:
        print_line(f"nothing can be said of the results: {error}", "yellow", console)
        return
    console.print(as_lines(content))
    warn_if_old(folder, noted, console)


def warn_if_old(folder: Path, noted: JsonObject, console: Console | None = None) -> None:
    """Print a line where a report's answer, as noted, is of other trials than the folder holds now."""
    if noted and noted.get("state") not in ("", Folder(folder).store.state()):  # "" is of one with settings of its own
        print_line(f"the report is older than the trials; write it again: bench report {folder}", "yellow", console)


def as_lines(content: JsonObject) -> Group:
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
