"""Print lines unchanged, and write durations as text."""

from __future__ import annotations

from rich.console import Console


def print_line(text: str, style: str | None = None, console: Console | None = None) -> None:
    """Print a text unchanged: without wrapping its lines or reading brackets as markup."""
    (console or Console()).print(text, style=style, markup=False, emoji=False, highlight=False, soft_wrap=True)


def duration(seconds: float) -> str:
    """Return a duration as text, to two units: "8 s", "12 min", "3 h 5 min", "2 d 4 h"."""
    whole = round(seconds)
    if whole < 120:
        return f"{whole} s"
    minutes, hours = round(whole / 60), round(whole / 3600)
    if minutes < 120:
        return f"{minutes} min"
    if hours < 48:
        return f"{minutes // 60} h {minutes % 60} min"
    return f"{hours // 24} d {hours % 24} h"
