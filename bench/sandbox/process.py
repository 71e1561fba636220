"""Call functions in a separate process: they may hang, print, exhaust memory, crash the interpreter or end it."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from math import inf
from queue import Empty, SimpleQueue
from threading import Thread, get_native_id
from time import monotonic
from types import TracebackType
from typing import IO, Any

from bench.sandbox.messages import describe_error, end_of_output
from bench.sandbox.server import UNANSWERABLE, receive, send

# Before any import the pipes move to other file numbers, out of reach of the code called; prints go to standard error.
_START = """
import json, os, sys
calls, answers, nowhere = os.dup(0), os.dup(1), os.open(os.devnull, os.O_RDWR)
os.dup2(nowhere, 0), os.dup2(2, 1)
sys.path[:], owner = json.loads(sys.argv.pop())
from bench.sandbox.server import serve
serve(calls, answers, owner)
"""

# One thread a process: times and results must not depend on the number of cores that a library finds.
_ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMEXPR_NUM_THREADS",
        "NUMBA_NUM_THREADS", "BLIS_NUM_THREADS",
    ),
    "1",
)  # fmt: skip

_LOOK = 0.2  # seconds between looks at a busy process: is it alive, and how much memory does it hold?
_TREE_LOOK = 1.0  # seconds, at least, between searches for the processes that it started
_GRACE = 0.5  # seconds to read what an ended process left in its pipes
_TAIL = 1 << 15  # bytes kept of standard error: a crash prints 100 frames and all extension modules
_DIRECT = 4096  # bytes that a pipe takes in one write, whether or not anyone reads it

Pulse = Callable[[int, int], None]
_Message = tuple[int, bytes] | None  # the call's number, and a pulse or an answer; None at the end of the pipe


class SilentError(RuntimeError):
    """The process gave no sign of life for longer than allowed."""


class MemoryExceededError(RuntimeError):
    """The process and those it started held more memory than allowed; the message states how much."""


class DiedError(RuntimeError):
    """The process ended without an answer."""

    def __init__(self, code: int, end_of_output: str = "") -> None:
        super().__init__(code, end_of_output)
        self.code = code  # after a signal, minus the signal's number
        self.end_of_output = end_of_output  # the last lines printed; after a crash, the kind and place of the crash

    def __str__(self) -> str:
        number = -self.code
        known = self.code < 0 and number in set(signal.Signals)
        return f"signal {signal.Signals(number).name}" if known else f"exit code {self.code}"


class RemoteError(RuntimeError):
    """The function called raised an exception, which the message describes."""


class Process:
    """A Python process that calls functions of importable modules, one after another.

    It ends at the latest with the process that started it. Any thread may create and use one, one thread at a time.

    Args:
        hash_seed: its PYTHONHASHSEED, which orders sets of strings.
        nested: whether another ``Process`` starts it, with which it ends.
    """

    def __init__(self, hash_seed: int, *, nested: bool = False) -> None:
        self._leads = hasattr(os, "killpg") and not nested  # it leads a session, so that all it starts can be ended
        self.pulse: tuple[int, int] | None = None  # the last one: evaluations made, budget
        main_thread = get_native_id() == os.getpid()
        given = json.dumps([[str(each) for each in sys.path], os.getpid() if main_thread else 0])
        own = {"PYTHONHASHSEED": str(hash_seed), "PYTHONIOENCODING": "utf-8"}
        self._process = subprocess.Popen(
            [sys.executable, "-c", _START, given], env=os.environ | _ONE_THREAD | own, bufsize=0,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=self._leads,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )  # fmt: skip
        self._calls, self._printed_before, self._ended = 0, 0, False
        self._messages, self._output = SimpleQueue[_Message](), _Output()
        self._listener = _start(_listen, self._process.stdout, self._messages)
        self._drain = _start(_keep_tail, self._process.stderr, self._output)
        self._sender: Thread | None = None
        self._tree = _ProcessTree(self._process.pid)

    def __enter__(self) -> Process:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @property
    def alive(self) -> bool:
        """Whether the process runs; when it does not, the processes that it started are ended too."""
        if self._process.poll() is None:
            return True
        self._end()
        return False

    @property
    def resident(self) -> int:
        """Bytes of memory that it and the processes it started hold; shared memory counts for each."""
        return self._tree.resident()

    @property
    def printed(self) -> int:
        """Bytes that the last call wrote to standard output and error, as far as they have been read."""
        return self._output.total - self._printed_before

    def close(self) -> None:
        """End the process and all that it started."""
        self._end()
        # A process that escaped the tree may hold a pipe open. Its thread then stays: closing the pipe would free a
        # file number that another pipe may take, and the thread would read that one.
        for thread in filter(None, (self._listener, self._drain, self._sender)):
            thread.join(_GRACE)
        if self._process.stdin is not None and not (self._sender is not None and self._sender.is_alive()):
            self._process.stdin.close()

    def call(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        patience: float | None,
        on_pulse: Pulse | None = None,
        memory: int | None = None,
    ) -> Any:
        """Call ``function(*arguments, pulse=…)`` in the process and return its result; all must be picklable.

        The function, of an importable module, calls ``pulse(made, budget)`` as a sign of life. After any error but a
        RemoteError the process is ended.

        Args:
            patience: seconds allowed without a sign of life; None for no limit.
            on_pulse: called with evaluations made and the budget, at most twice a second.
            memory: bytes that the process may hold (:attr:`resident`); None for no limit.

        Raises:
            SilentError: when neither a pulse nor the answer came for ``patience`` seconds.
            MemoryExceededError: when the process held more than ``memory`` bytes.
            DiedError: when the process ended first.
            RemoteError: when the function raised, or its answer cannot be pickled.
        """
        self.pulse = None
        self._calls += 1
        self._printed_before = self._output.total
        self._send(pickle.dumps((function, arguments)))
        limit = inf if patience is None else patience
        last_sign = monotonic()
        look = last_sign + _LOOK
        while True:
            try:
                message = self._messages.get(timeout=max(0.0, min(look, last_sign + limit) - monotonic()))
            except Empty:
                if monotonic() >= last_sign + limit:
                    self._end()
                    raise SilentError(f"{patience:g} s") from None
            else:
                if message is None:
                    raise self._died_error()
                number, payload = message
                if number == self._calls:  # not of an earlier call that an interrupt cut short
                    last_sign = monotonic()
                    kind, value = _load(payload)
                    if kind != "pulse":
                        self._output.tail.clear()  # it did not end, so its output is of no interest
                        if kind == "error":
                            raise RemoteError(value)
                        return value
                    self.pulse = value
                    if on_pulse is not None:
                        on_pulse(*value)
            if monotonic() >= look:
                self._inspect(memory)
                look = monotonic() + _LOOK

    def _send(self, call: bytes) -> None:
        with suppress(OSError, ValueError):  # an ended or closed process is detected below
            pipe = self._process.stdin.fileno()  # type: ignore[union-attr]
            if len(call) <= _DIRECT:
                send(pipe, self._calls, call)
            else:  # in a thread: a process that hangs may never read it
                self._sender = _start(_send, pipe, self._calls, call)

    def _inspect(self, memory: int | None) -> None:
        """Detect a process that has ended silently, or end one that has grown too large."""
        if not self.alive:
            self._listener.join(_GRACE)
            self._messages.put(None)  # a fork that still holds the pipe hides its end
        elif memory is not None and (held := self.resident) > memory:
            self._end()
            raise MemoryExceededError(
                f"it held {held / 1e6:,.0f} MB of memory, where {memory / 1e6:,.0f} MB are allowed"
            )

    def _died_error(self) -> DiedError:
        code = UNANSWERABLE  # for a process that only closed its pipe
        with suppress(subprocess.TimeoutExpired):
            code = self._process.wait(_GRACE)
        self._end()
        self._drain.join(_GRACE)
        return DiedError(code, end_of_output(bytes(self._output.tail)))

    def _end(self) -> None:
        if self._ended:  # another process may have its number by now
            return
        self._tree.look()
        with suppress(OSError):
            if self._leads:
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
        self._tree.kill()
        self._ended = True
        with suppress(subprocess.TimeoutExpired):  # a process that waits for a dead disk cannot be ended
            self._process.wait(10 * _GRACE)


class _Output:
    """What a process has printed: the number of bytes, and the last of them."""

    def __init__(self) -> None:
        self.total, self.tail = 0, bytearray()


class _ProcessTree:
    """A process and all that it started, including those in sessions of their own."""

    def __init__(self, pid: int) -> None:
        import psutil  # not at the top: its import takes as long as all others of this module

        self._quietly = suppress(psutil.Error, OSError)
        self._members: set[Any] = set()
        self._next = 0.0
        with self._quietly:
            self._members.add(psutil.Process(pid))
        self._first = next(iter(self._members), None)

    def look(self) -> None:
        """Search for members; known ones are kept while they run, as a child may outlive its parent."""
        began = monotonic()
        with self._quietly:
            self._members = {each for each in self._members if each.is_running()}
            if self._first is not None:
                self._members.update((self._first, *self._first.children(recursive=True)))
        now = monotonic()
        self._next = now + max(_TREE_LOOK, 50 * (now - began))  # a search reads a file of every process on the machine

    def resident(self) -> int:
        """Return the bytes of memory that the members hold."""
        if monotonic() >= self._next:
            self.look()
        held = 0
        for member in self._members:
            with self._quietly:
                held += member.memory_info().rss
        return held

    def kill(self) -> None:
        """End the members that are known."""
        for member in self._members:
            with self._quietly:
                member.kill()


def _start(work: Callable[..., None], *arguments: Any) -> Thread:
    thread = Thread(target=work, args=arguments, daemon=True)
    thread.start()
    return thread


def _listen(pipe: IO[bytes], messages: SimpleQueue[_Message]) -> None:
    with pipe, suppress(EOFError, OSError):
        while True:
            messages.put(receive(pipe.fileno()))
    messages.put(None)


def _keep_tail(pipe: IO[bytes], output: _Output) -> None:
    with pipe, suppress(OSError):
        while chunk := os.read(pipe.fileno(), 1 << 16):
            output.total += len(chunk)
            output.tail += chunk
            del output.tail[:-_TAIL]


def _send(pipe: int, number: int, call: bytes) -> None:
    with suppress(OSError):
        send(pipe, number, call)


def _load(payload: bytes) -> Any:
    try:
        return pickle.loads(payload)
    except Exception as error:
        return "error", f"its answer cannot be read: {describe_error(error)}"
