"""Ctrl-C that waits for what must not be cut in two."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType


class Interrupts:
    """Interrupts of a run: let in while it waits, kept until then while it commits."""

    def __init__(self) -> None:
        self._open = self._pending = False

    def arrive(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - a signal handler
        """Take a signal: raise it now, or as soon as the run waits."""
        self._pending = True
        if self._open:
            raise KeyboardInterrupt

    @contextmanager
    def welcome(self) -> Iterator[None]:
        """Raise KeyboardInterrupt within, for a signal that comes now or came before."""
        self._open = True
        try:
            if self._pending:
                raise KeyboardInterrupt
            yield
        finally:
            self._open = False


@contextmanager
def deferred() -> Iterator[Interrupts]:
    """Yield the interrupts of the signals that raise KeyboardInterrupt, which do so only where they are welcome."""
    interrupts = Interrupts()
    numbers = []
    if current_thread() is main_thread():
        mine = (signal.SIGINT, signal.SIGTERM)
        numbers = [number for number in mine if signal.getsignal(number) is signal.default_int_handler]
    for number in numbers:
        signal.signal(number, interrupts.arrive)
    try:
        yield interrupts
    finally:
        for number in numbers:
            signal.signal(number, signal.default_int_handler)
