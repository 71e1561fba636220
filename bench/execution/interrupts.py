"""Ctrl-C that waits for what must not be cut in two."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType

Handler = Callable[[int, FrameType | None], object]


class Interrupts:
    """Interrupts of a run: let in while it waits, kept until then while it commits.

    Attributes:
        pending: whether one came.
    """

    def __init__(self) -> None:
        self.pending = self._allowed = False

    def handle(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - a signal handler
        """Take a signal: raise it now, or as soon as the run waits."""
        self.pending = True
        if self._allowed:
            raise KeyboardInterrupt

    @contextmanager
    def allowed(self) -> Iterator[None]:
        """Raise KeyboardInterrupt within, for a signal that comes now or came before."""
        self._allowed = True
        try:
            if self.pending:
                raise KeyboardInterrupt
            yield
        finally:
            self._allowed = False


@contextmanager
def interrupts_deferred() -> Iterator[Interrupts]:
    """Yield the interrupts of the signals that raise KeyboardInterrupt, which do so only where they are allowed.

    One that came where no other could raise it does so at the end; any that come after one was raised do nothing.
    """
    interrupts = Interrupts()
    with _handlers_replaced(interrupts.handle, lambda handler: handler is signal.default_int_handler):
        yield interrupts
    if interrupts.pending:
        raise KeyboardInterrupt


@contextmanager
def signals_delayed() -> Iterator[None]:
    """Put signals off until the end: what is interrupted while it starts may leave half of it behind."""
    came: set[int] = set()
    try:
        with _handlers_replaced(lambda number, _: came.add(number), callable):
            yield
    finally:
        for number in came:
            signal.raise_signal(number)


@contextmanager
def _handlers_replaced(handler: Handler, concerns: Callable[[object], bool]) -> Iterator[None]:
    """Have the handler take the signals whose present handlers it concerns; only a main thread has any."""
    main = current_thread() is main_thread()
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM) if main}
    before = {number: present for number, present in before.items() if concerns(present)}
    for number in before:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, present in before.items():
            signal.signal(number, present)
