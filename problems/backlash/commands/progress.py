"""Show a bar on what takes longer than two seconds, on a terminal."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from threading import Timer
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress

Item = TypeVar("Item")

LATE = 2.0  # seconds before the bar appears


@contextmanager
def progress(
    title: str, total: int, console: Console | None = None, late: float = LATE
) -> Iterator[Callable[[Iterable[Item]], Iterable[Item]]]:
    """Yield a function that returns the items given to it, and counts them on a bar.

    Args:
        title: the word beside the bar.
        total: the number of items; a bar of one is a moving one.
        console: where the bar is drawn, standard error by default; none is drawn on anything but a terminal.
        late: seconds before the bar appears.
    """
    bar = Progress(console=console or Console(stderr=True), transient=True)
    timer = Timer(late, bar.start)
    timer.daemon = True
    if bar.console.is_terminal:
        timer.start()
    try:
        yield lambda items: bar.track(items, total if total > 1 else None, description=title)
    finally:
        timer.cancel()
        if bar.live.is_started:  # else it would print an empty line
            bar.stop()
