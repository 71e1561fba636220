"""A process of one's own for code that may hang, print, crash the interpreter or end it."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, Queue
from threading import Thread
from time import monotonic
from types import TracebackType
from typing import Any, BinaryIO

_START = "import json, sys; sys.path[:] = json.loads(sys.argv.pop()); from bench.check.isolation import serve; serve()"
_PULSE = 0.5  # seconds between the pulses that are passed on
_END = None, None

Pulse = Callable[[int, int], None]


class SilentError(RuntimeError):
    """The process gave no sign of life for as long as was allowed."""


class DiedError(RuntimeError):
    """The process ended without an answer; ``code`` is its exit code, minus the signal where one ended it."""

    def __init__(self, code: int) -> None:
        self.code = code
        number = -code
        known = code < 0 and number in set(signal.Signals)
        super().__init__(f"signal {signal.Signals(number).name}" if known else f"exit code {code}")


class RemoteError(RuntimeError):
    """What was called raised an exception; the message says which."""


class Process:
    """A Python process that calls functions of importable modules, one after another.

    Args:
        hash_seed: what orders its sets of texts.
        nested: whether it is started by such a process, and ends with it.
    """

    def __init__(self, hash_seed: int, *, nested: bool = False) -> None:
        self._leads = hasattr(os, "killpg") and not nested  # a session, so that all it starts can be ended
        self.pulse: tuple[int, int] | None = None  # the last one: evaluations made, and the budget
        command = [sys.executable, "-c", _START, json.dumps([str(each) for each in sys.path])]
        environment = os.environ | {"PYTHONHASHSEED": str(hash_seed), "PYTHONIOENCODING": "utf-8"}
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment,
            start_new_session=self._leads,
        )  # fmt: skip
        self._messages: Queue[tuple[Any, Any]] = Queue()
        Thread(target=self._listen, daemon=True).start()

    def __enter__(self) -> Process:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """End the process and whatever it started."""
        with suppress(OSError):
            if self._leads:
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                pipe.close()  # type: ignore[union-attr]

    def call(
        self, function: Callable[..., Any], *arguments: Any, patience: float, on_pulse: Pulse | None = None
    ) -> Any:
        """Return ``function(*arguments, pulse=…)`` of the process; all must be picklable.

        The function calls ``pulse(made, budget)`` as a sign of life, which ``on_pulse`` passes on.

        Raises:
            SilentError: when neither a pulse nor the answer came for ``patience`` seconds.
            DiedError: when the process ended first.
            RemoteError: when the function raised.
        """
        self.pulse = None
        with suppress(OSError):  # a process that is gone says so below
            pickle.dump((function, arguments), self._process.stdin)  # type: ignore[arg-type]
            self._process.stdin.flush()  # type: ignore[union-attr]
        while True:
            try:
                kind, value = self._messages.get(timeout=patience)
            except Empty:
                raise SilentError(f"{patience:g} s") from None
            if kind == "pulse":
                self.pulse = value
                if on_pulse is not None:
                    on_pulse(*value)
            elif kind == "answer":
                return value
            elif kind == "error":
                raise RemoteError(value)
            else:
                raise DiedError(self._process.wait(timeout=patience))

    def _listen(self) -> None:
        with suppress(Exception):  # its end, or a message that its end cut short
            while True:
                self._messages.put(pickle.load(self._process.stdout))  # type: ignore[arg-type]
        self._messages.put(_END)


def serve() -> None:
    """Answer calls until there are no more: the other side of :class:`Process`.

    The pipes are kept out of the reach of what is called: its prints go nowhere, and what it reads is empty.
    """
    calls, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(nowhere, descriptor)
    with suppress(EOFError):
        while True:
            function, arguments = pickle.load(calls)
            try:
                answer = "answer", function(*arguments, pulse=_Pulse(answers))
            except (Exception, SystemExit) as error:
                answer = "error", spell(error)
            _send(answers, answer)


def spell(error: BaseException) -> str:
    """Return an exception as one line: its type, and what it says."""
    return f"{type(error).__name__}: {str(error).strip() or 'no message'}".splitlines()[0]


class _Pulse:
    """Passes evaluations made on, at most every half second but for the budget's end."""

    def __init__(self, answers: BinaryIO) -> None:
        self._answers, self._next = answers, 0.0

    def __call__(self, made: int, budget: int) -> None:
        if made == budget or monotonic() >= self._next:
            self._next = monotonic() + _PULSE
            _send(self._answers, ("pulse", (made, budget)))


def _send(answers: BinaryIO, message: tuple[str, Any]) -> None:
    answers.write(pickle.dumps(message))  # in one piece, whatever threads there are
    answers.flush()
