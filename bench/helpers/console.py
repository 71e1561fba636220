"""Print lines unchanged, errors and progress; write durations as text; read options as KEY=VALUE."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject, parse_toml
from bench.helpers.text import printable

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn

# rich is imported at the first line: optimizers import this package, and their processes print nothing.

LONGEST = 2000
"""Characters of an error message."""

OnStep = Callable[[str, int, int], None]
"""Called before each step of what takes long, with its title, the steps done and all steps."""


def print_line(text: str, style: str | None = None, console: Console | None = None) -> None:
    """Print a text unchanged: without wrapping its lines or reading brackets as markup."""
    from rich.console import Console

    (console or Console()).print(text, style=style, markup=False, emoji=False, highlight=False, soft_wrap=True)


def print_error(message: str) -> None:
    """Print one red line on standard error; a message may quote a text of any length, and is cut."""
    from rich.console import Console

    print_line(f"bench: {printable(message, LONGEST)}", "red", Console(stderr=True))


@contextmanager
def steps(console: Console, name: str) -> Iterator[OnStep]:
    """Display a progress bar; yield a function to call before each step: its title, steps done, steps in total."""
    from rich.progress import TextColumn

    title = TextColumn("{task.description}", markup=False)
    with bars(console, "{task.fields[name]}", title, transient=True) as progress:
        task = progress.add_task("", name=name, total=None)

        def show(title: str, done: int, total: int) -> None:
            progress.update(task, description=title, completed=done, total=total)

        yield show


def bars(console: Console, name: str, *columns: ProgressColumn, transient: bool = False) -> Progress:
    """Return progress bars of named tasks, displayed on a terminal only."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    named = TextColumn(name, markup=False), BarColumn(), MofNCompleteColumn()
    return Progress(*named, *columns, console=console, disable=not console.is_terminal, transient=transient)


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


def pairs(items: list[str] | None) -> JsonObject:
    """Parse KEY=VALUE texts into options; a value that is not TOML is a text."""
    options: JsonObject = {}
    for item in items or []:
        key, equals, value = item.partition("=")
        if not equals or not key.strip():
            raise BenchError(f"{item!r} is not KEY=VALUE, as in agents=300")
        try:
            options[key.strip()] = parse_toml(f"value = {value}")["value"]
        except ValueError:
            options[key.strip()] = value
    return options
