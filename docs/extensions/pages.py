"""Write generated pages, and no file that has not changed, so that Sphinx reads only what has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any


def write(folder: Path, pages: Mapping[str, str]) -> None:
    """Make the Markdown files of a folder those of ``pages``, by name without suffix."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.md"):
        if old.stem not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table; cells are Markdown already, and have no line breaks."""
    lines = [head, ["-"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def code(text: object) -> str:
    """Return a text in code font."""
    return f"``{text}``" if "`" in str(text) else f"`{text}`"


def plain(text: str) -> str:
    """Return a text in which Markdown reads no markup."""
    return escaped(" ".join(text.split()))


def escaped(text: str) -> str:
    """Return a text whose letters mean nothing to Markdown, its spaces as they are."""
    return "".join(f"\\{letter}" if letter in "\\`*_[]<>#$" else letter for letter in text)


def with_code(text: str) -> str:
    """Return a text in which Markdown reads no markup but the backticks of code."""
    parts = text.split("`")
    if len(parts) % 2 == 0:
        return plain(text)
    return "".join(code(part) if at % 2 else escaped(part) for at, part in enumerate(parts))


def performance(measured: dict[str, Any]) -> str:
    """Return the Markdown of what was measured."""
    packages = ", ".join(f"{name} {version}" for name, version in measured["packages"].items())
    commit = str((measured["git"] or {}).get("commit") or "unknown")[:10]
    warning = "**A trial run with small sizes: these numbers mean nothing.** " if measured["quick"] else ""
    about = (
        f"{warning}Measured on {measured['date']} on {measured['cores']} cores of {measured['processor']}, "
        f"{measured['memory_gb']:.0f} GB, {measured['system']}, with Python {measured['python']}, {packages}; "
        f"commit {commit}."
    )
    if (load := measured.get("load", 0)) >= 0.5:
        about += f" The machine was not idle: its load was {load} when the run began."
    rows = [(with_code(row["measured"]), with_code(row["value"]), code(row["command"])) for row in measured["rows"]]
    return f"{about}\n\n{table(('measured', 'value', 'command'), rows)}\n"
