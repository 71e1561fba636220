"""Show the answer of a report in a terminal: the verdict's first sentence and a short table.

Nothing of :mod:`bench.report` is imported, which would take seconds.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from bench.cli.console import table
from bench.helpers.parsing import parse_json, read_text
from bench.storage.folder import ANSWER


def read(folder: Path) -> dict[str, Any]:
    """Return the answer of the report in a folder; empty where there is none that can be read."""
    try:
        content = parse_json(read_text(folder / ANSWER))
        return content if isinstance(content, dict) and isinstance(content.get("rows"), list) else {}
    except (OSError, ValueError):
        return {}


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
