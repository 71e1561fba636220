"""Defer KeyboardInterrupt until a commit is complete."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType

Handler = Callable[[int, FrameType | None], object]


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
    """
    interrupts = Interrupts()
    with _handlers_replaced(interrupts.handle, lambda handler: handler is signal.default_int_handler):
        yield interrupts
    if interrupts.pending:
        raise KeyboardInterrupt


@contextmanager
def signals_delayed() -> Iterator[None]:
    """Delay signals until the context ends, such as around a start that must not stop halfway."""
    arrived: set[int] = set()
    try:
        with _handlers_replaced(lambda number, _: arrived.add(number), callable):
            yield
    finally:
        for number in arrived:
            signal.raise_signal(number)


@contextmanager
def _handlers_replaced(handler: Handler, concerns: Callable[[object], bool]) -> Iterator[None]:
    """Replace the present handlers that ``concerns`` selects; outside the main thread there are none to replace."""
    numbers = (signal.SIGINT, signal.SIGTERM) if current_thread() is main_thread() else ()
    before = {number: present for number in numbers if concerns(present := signal.getsignal(number))}
    for number in before:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, present in before.items():
            signal.signal(number, present)
