"""Write texts, which may contain anything, as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table, whose cells are Markdown already."""
    lines = [head, ["-"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def code(text: str) -> str:
    """Return a text in code font."""
    return f"``{text}``" if "`" in text else f"`{text}`"


def plain(text: str) -> str:
    """Return a text on one line in which Markdown reads no markup."""
    return "".join(f"\\{letter}" if letter in "\\`*_[]<>#$" else letter for letter in " ".join(text.split()))
