"""A process of one's own for code that may hang, print, eat memory, crash the interpreter or end it."""

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

# The pipes are put out of the reach of what is called before anything is imported; prints go to standard error.
_START = """
import json, os, sys
calls, answers, nowhere = os.dup(0), os.dup(1), os.open(os.devnull, os.O_RDWR)
os.dup2(nowhere, 0), os.dup2(2, 1)
sys.path[:], owner = json.loads(sys.argv.pop())
from bench.sandbox.server import serve
serve(calls, answers, owner)
"""

# A process is one thread's work: times and results must not depend on how many cores a library finds.
_ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMEXPR_NUM_THREADS",
        "NUMBA_NUM_THREADS", "BLIS_NUM_THREADS",
    ),
    "1",
)  # fmt: skip

_LOOK = 0.2  # seconds between looks at a process that is at work: is it there, and how large is it?
_TREE_LOOK = 1.0  # seconds, at least, between looks for the processes that it started
_GRACE = 0.5  # seconds for what a process that has ended left in its pipes
_TAIL = 1 << 15  # bytes kept of standard error: a crash tells 100 frames and all extension modules
_DIRECT = 4096  # bytes that a pipe takes at once, whether or not anyone reads it

Pulse = Callable[[int, int], None]
_Message = tuple[int, bytes] | None  # the call's number, and a pulse or answer; None at the end of the pipe


class SilentError(RuntimeError):
    """The process gave no sign of life for as long as was allowed."""


class MemoryExceededError(RuntimeError):
    """The process, with all that it started, held more memory than was allowed; the message says how much."""


class DiedError(RuntimeError):
    """The process ended without an answer.

    Attributes:
        code: its exit code, minus the signal where one ended it.
        end_of_output: the end of what it printed, in lines; of a crash, its kind and place.
    """

    def __init__(self, code: int, end_of_output: str = "") -> None:
        super().__init__(code, end_of_output)
        self.code, self.end_of_output = code, end_of_output

    def __str__(self) -> str:
        number = -self.code
        known = self.code < 0 and number in set(signal.Signals)
        return f"signal {signal.Signals(number).name}" if known else f"exit code {self.code}"


class RemoteError(RuntimeError):
    """What was called raised an exception; the message says which."""


class Process:
    """A Python process that calls functions of importable modules, one after another.

    It ends with the process that started it, at the latest; any thread may make and use one, one thread at a time.

    Args:
        hash_seed: what orders its sets of texts.
        nested: whether it is started by such a process, and ends with it.
    """

    def __init__(self, hash_seed: int, *, nested: bool = False) -> None:
        self._leads = hasattr(os, "killpg") and not nested  # a session, so that all it starts can be ended
        self.pulse: tuple[int, int] | None = None  # the last one: evaluations made, and the budget
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
        """Whether the process is there; when it is not, what it started is ended too."""
        if self._process.poll() is None:
            return True
        self._end()
        return False

    @property
    def resident(self) -> int:
        """Bytes of memory that it and all it started hold; what they share counts for each."""
        return self._tree.resident()

    @property
    def printed(self) -> int:
        """Bytes that the last call wrote to standard output and error, but for those still in the pipe."""
        return self._output.total - self._printed_before

    def close(self) -> None:
        """End the process and whatever it started."""
        self._end()
        # What has left the process's family may hold a pipe open: its thread then stays, for a pipe that is closed
        # under a thread may come to life as another's.
        threads = [each for each in (self._listener, self._drain, self._sender) if each is not None]
        for thread in threads:
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
        """Return ``function(*arguments, pulse=…)`` of the process; all must be picklable.

        The function calls ``pulse(made, budget)`` as a sign of life, which ``on_pulse`` passes on. After any error but
        a RemoteError the process is ended.

        Args:
            function: of an importable module.
            arguments: of the function.
            patience: seconds without a sign of life that are allowed; None for any.
            on_pulse: called with evaluations made and the budget, at most twice a second.
            memory: bytes that the process may hold, see :attr:`resident`; None for any.

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
                if number == self._calls:  # and not of a call that was left by an interrupt
                    last_sign = monotonic()
                    kind, value = _load(payload)
                    if kind != "pulse":
                        self._output.tail.clear()  # no last words after all
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
        with suppress(OSError, ValueError):  # a process that is gone, or closed, says so below
            pipe = self._process.stdin.fileno()  # type: ignore[union-attr]
            if len(call) <= _DIRECT:
                send(pipe, self._calls, call)
            else:  # a process that hangs may leave it unread
                self._sender = _start(_send, pipe, self._calls, call)

    def _inspect(self, memory: int | None) -> None:
        """See to a process that is silent because it ended, or has grown too large."""
        if not self.alive:
            self._listener.join(_GRACE)
            self._messages.put(None)  # a fork that still has the pipe keeps its end from being seen
        elif memory is not None and (held := self.resident) > memory:
            self._end()
            raise MemoryExceededError(
                f"it held {held / 1e6:,.0f} MB of memory, where {memory / 1e6:,.0f} MB are allowed"
            )

    def _died_error(self) -> DiedError:
        code = UNANSWERABLE  # of a process that only closed its pipe
        with suppress(subprocess.TimeoutExpired):
            code = self._process.wait(_GRACE)
        self._end()
        self._drain.join(_GRACE)
        return DiedError(code, end_of_output(bytes(self._output.tail)))

    def _end(self) -> None:
        if self._ended:  # its number may be another's by now
            return
        self._tree.look()
        with suppress(OSError):
            if self._leads:
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
        self._tree.kill()
        self._ended = True
        with suppress(subprocess.TimeoutExpired):  # one that waits for a dead disk cannot be ended
            self._process.wait(10 * _GRACE)


class _Output:
    """What a process prints: how many bytes, and the last of them."""

    def __init__(self) -> None:
        self.total, self.tail = 0, bytearray()


class _ProcessTree:
    """A process and all that it started, also in sessions of their own."""

    def __init__(self, pid: int) -> None:
        import psutil  # here, since it takes as long as all else that this module needs

        self._quietly = suppress(psutil.Error, OSError)
        self._members: set[Any] = set()
        self._next = 0.0
        with self._quietly:
            self._members.add(psutil.Process(pid))
        self._first = next(iter(self._members), None)

    def look(self) -> None:
        """Look for members; those known stay while they run, for a child may outlive what started it."""
        began = monotonic()
        with self._quietly:
            self._members = {each for each in self._members if each.is_running()}
            if self._first is not None:
                self._members.update((self._first, *self._first.children(recursive=True)))
        now = monotonic()
        self._next = now + max(_TREE_LOOK, 50 * (now - began))  # it reads a file of every process of the machine

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
