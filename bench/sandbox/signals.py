"""Defer KeyboardInterrupt until a commit is complete."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType


class Interrupts:
    """The interrupts of a run: raised while the run waits, deferred while it commits; ``pending`` once one came."""

    def __init__(self) -> None:
        self.pending = self._allowed = False

    def handle(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - a signal handler
        """Handle a signal: raise KeyboardInterrupt now, or as soon as the run waits."""
        self.pending = True
        if self._allowed:
            raise KeyboardInterrupt

    @contextmanager
    def allowed(self) -> Iterator[None]:
        """Raise KeyboardInterrupt in this context for a signal that arrives now or has arrived before."""
        self._allowed = True
        try:
            if self.pending:
                raise KeyboardInterrupt
            yield
        finally:
            self._allowed = False


@contextmanager
def interrupts_deferred() -> Iterator[Interrupts]:
    """Let signals raise KeyboardInterrupt only within :meth:`Interrupts.allowed` of the object yielded.

    A signal that arrives after the last such context raises at the end; signals after the first raise nothing more.
    Outside the main thread there are none to defer.
    """
    interrupts = Interrupts()
    numbers = (signal.SIGINT, signal.SIGTERM) if current_thread() is main_thread() else ()
    deferred = [number for number in numbers if signal.getsignal(number) is signal.default_int_handler]
    for number in deferred:
        signal.signal(number, interrupts.handle)
    try:
        yield interrupts
    finally:
        for number in deferred:
            signal.signal(number, signal.default_int_handler)
    if interrupts.pending:
        raise KeyboardInterrupt
