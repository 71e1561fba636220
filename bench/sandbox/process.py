"""Call functions in separate processes: they may hang, print, exhaust memory, crash the interpreter or end it."""

from __future__ import annotations

import json
import os
import pickle
import signal
import socket
import subprocess
import sys
import tempfile
import weakref
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from math import inf
from time import monotonic
from typing import IO, Any

from bench.sandbox import tree
from bench.sandbox.bubblewrap import VARIABLES, Sandbox
from bench.sandbox.channel import BrokenChannelError, Channel
from bench.sandbox.messages import end_of_output
from bench.sandbox.server import UNANSWERABLE

# Before any import the channel is all that a process has of its owner: prints go to a file. It imports nothing from the
# working folder (-P), and what its owner found elsewhere than every Python does, comes last: no file there may shadow
# the standard library or what is installed.
_START = """
import json, sys
path, end, owner, forks = json.loads(sys.argv.pop())
sys.path[:] = sorted(path, key=lambda place: place not in sys.path)
if isinstance(end, str):
    import socket
    end = socket.fromshare(sys.stdin.buffer.read()).detach()
from bench.sandbox.server import serve
serve(end, owner, forks)
"""

# One thread a process: times and results must not depend on the number of cores that a library finds.
_ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMEXPR_NUM_THREADS",
        "NUMBA_NUM_THREADS", "BLIS_NUM_THREADS",
    ),
    "1",
) | {"JE_ARROW_MALLOC_CONF": "background_thread:false"}  # fmt: skip
# The last one is of pyarrow, which pandas imports where it is installed: a process with its thread cannot be forked.

_PAUSE = (
    1.0  # seconds that a wait is late after which this process was stopped, as all are where a cluster suspends a job
)
_LOOK = 0.2  # seconds between looks at a busy process: is it alive, how much memory does it hold, has it printed?
_GRACE = 0.5  # seconds for a process that has closed its channel to end
_ANSWER = 10.0  # seconds for a process that waits for nothing but requests to answer one
_MOST = 1_000_000  # values of an answer; a message of empty ones takes 25 times its size of memory
_TAIL = 1 << 15  # bytes read of the output: a crash prints 100 frames and all extension modules


class TimeExceededError(RuntimeError):
    """The call took longer than allowed."""


class MemoryExceededError(RuntimeError):
    """The process and all that it started hold more memory than allowed."""


class PrintedTooMuchError(RuntimeError):
    """The process printed more than allowed."""


class TooManyProcessesError(RuntimeError):
    """The process has started more others than allowed."""


class LostError(RuntimeError):
    """The process was ended, or the one that forks and ends it has ended, or answers no more."""


class DiedError(RuntimeError):
    """The process ended without an answer."""

    def __init__(self, code: int, end_of_output: str = "") -> None:
        super().__init__(code, end_of_output)
        self.code = code  # after a signal, minus the signal's number; a sandbox's is 128 and the number
        self.end_of_output = end_of_output  # the last lines printed; after a crash, the kind and place of the crash

    def __str__(self) -> str:
        number = -self.code if self.code < 0 else self.code - 128
        return f"signal {signal.Signals(number).name}" if number in set(signal.Signals) else f"exit code {self.code}"


class RemoteError(RuntimeError):
    """The function called raised an exception, which the message describes, or gave an answer that is no JSON."""


FAILURES = (
    TimeExceededError, MemoryExceededError, PrintedTooMuchError, TooManyProcessesError, DiedError, RemoteError,
)  # fmt: skip
"""Errors of a call that plug-in code can cause; a LostError may have any cause."""


class Process(AbstractContextManager["Process"]):
    """A Python process that calls functions of importable modules, one after another, and forks copies of itself.

    It ends at the latest with the process that started it, a copy with its original. One thread at a time may use a
    process or its copies.

    Args:
        hash_seed: its PYTHONHASHSEED, which orders sets of strings.
        forks: whether it is there to be forked rather than to run plug-in code for long.
        sandbox: in which it runs; None for none.
    """

    _process: subprocess.Popen[bytes] | None

    def __init__(self, hash_seed: int = 0, *, forks: bool = False, sandbox: Sandbox | None = None) -> None:
        end = self._set_up()
        share = hasattr(end, "share")  # on Windows
        owner = 0 if sandbox else os.getpid()  # a sandbox ends with its owner by itself
        settings = json.dumps([[*map(str, sys.path)], "" if share else end.fileno(), owner, forks])
        environment = {"PYTHONHASHSEED": str(hash_seed), "PYTHONIOENCODING": "utf-8"}
        found = os.environ if sandbox is None else {name: os.environ[name] for name in VARIABLES if name in os.environ}
        with end, sandbox.opened() if sandbox else nullcontext(((), ())) as (words, files):
            process = subprocess.Popen(
                [*words, sys.executable, "-P", "-c", _START, settings], env={**found, **_ONE_THREAD, **environment},
                stdin=subprocess.PIPE if share else subprocess.DEVNULL, stdout=self._output, stderr=self._output,
                pass_fds=() if share else [end.fileno(), *files], start_new_session=hasattr(os, "killpg"),
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )  # fmt: skip
            self._process = process
            if share and process.stdin is not None:
                with process.stdin as pipe:
                    pipe.write(end.share(process.pid))  # type: ignore[attr-defined]

    def _set_up(self) -> socket.socket:
        """Set what an owner holds of a process; return the end of the channel for the process itself."""
        own_end, end = socket.socketpair()
        self._channel, self._output = Channel(own_end), tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
        # Of one that ended with its original and was never closed; unlike __del__, before sockets in a cycle warn.
        weakref.finalize(self, _let_go, self._channel, self._output).atexit = False
        self._original: Process | None = None  # that this process was forked from
        self._process = None
        self._pid = self._number = 0
        self._closed = self._lost = False
        self.note: Any = None  # the last one of the present call (bench.sandbox.server.note)
        return end

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def closed(self) -> bool:
        """Whether the process, or the one it was forked from, was closed, or ended after an error."""
        return self._closed or (self._original is not None and self._original.closed)

    @property
    def printed(self) -> int:
        """Bytes written to standard output and error since the last call began."""
        return os.fstat(self._output.fileno()).st_size

    def fork(self) -> Process | None:
        """Return a copy of this process, None where a fork is unsafe, as this one runs threads.

        In a sandbox the copy has namespaces of its own, and a fork is also unsafe where this process holds files or
        memory that the copy would share with others.

        Raises:
            LostError: when this process has ended, or does not answer.
            RemoteError: when plug-in code answers in its place.
        """
        copy = object.__new__(Process)
        with copy._set_up() as end:
            pid = self._request("fork", files=(end.fileno(), copy._output.fileno()))
        if pid is None or pid <= 0:
            return None
        copy._original, copy._pid = self, pid
        return copy

    def call(self, function: Callable[..., object], *arguments: object, **limits: Any) -> Any:
        """Call a function and return its answer; see :meth:`start`, and :meth:`finish` for the limits."""
        self.start(function, *arguments)
        return self.finish(**limits)

    def start(self, function: Callable[..., object], *arguments: object, files: Sequence[int] = ()) -> None:
        """Begin a call of a function of an importable module, whose answer :meth:`finish` returns.

        The arguments are pickled; open files are passed on as further arguments.

        Raises:
            LostError: when the process has been closed, or was ended after an error.
        """
        if self.closed:
            raise LostError("it has been ended")
        self.note = None
        if self.printed:
            self._output.truncate(0)
            self._output.seek(0)
        self._number += 1
        try:
            self._channel.send(self._number, pickle.dumps(("call", function, *arguments)), files, _ANSWER)
        except BrokenChannelError:  # it has ended, or takes no call: finish() finds the channel closed, and says why
            self._channel.close()

    def finish(
        self,
        *,
        seconds: float | None,
        memory: int | None = None,
        printed: int | None = None,
        beside: Sequence[Process] = (),
    ) -> Any:
        """Return the answer to the call begun by :meth:`start`, of which JSON is made; it is not unpickled.

        After any error the process is ended.

        Args:
            seconds: that the call may take; None to wait for as long as the process is alive.
            memory: bytes that the process and all that it started may hold; None for no limit.
            printed: bytes that the call may print; None for no limit.
            beside: processes whose calls were begun too, held to the same limit of memory.

        Raises:
            TimeExceededError, MemoryExceededError, PrintedTooMuchError, TooManyProcessesError: when the call exceeded a
                limit.
            DiedError: when the process ended first.
            LostError: when it was ended before, or its original has ended, or does not answer.
            RemoteError: when the function raised, or its answer is no JSON.
        """
        now = monotonic()
        end, look = now + (inf if seconds is None else seconds), now + _LOOK
        while True:
            began, wait = now, max(0.0, min(look, end) - now)
            try:
                message = self._channel.receive(wait)
            except BrokenChannelError:
                raise self._died_error() from None
            now = monotonic()
            if (paused := now - began - wait) > _PAUSE:  # the others may be continued a little later than this process
                end, look = end + paused, now + _LOOK
            if message is not None:
                kind, value = self._load(*message)
                if kind == "value":
                    self._check_printed(printed)
                    return value
                if kind == "error":
                    self.close()
                    raise RemoteError(str(value))
                self.note = value
            if now >= end:
                self.close()
                raise TimeExceededError(f"{seconds:g} s")
            if now >= look:
                self._check_printed(printed)
                for process in (self, *beside):
                    process._check_state(memory)
                look = monotonic() + _LOOK

    def close(self) -> None:
        """End the process and all that it started, its copies included.

        Raises:
            LostError: when the process that it was forked from, and that ends it, has ended or does not answer.
            RemoteError: when plug-in code answers in the place of that one.
        """
        try:
            self._end()
        finally:
            self._output.close()

    def kill(self) -> None:
        """End a process that was not forked, and its copies; any thread may do so, and its user finds it ended."""
        self._end_process(0.0)

    def _load(self, number: int, payload: bytes) -> tuple[str, object]:
        """Return the kind and the value of a message; end a process whose message answers no call."""
        with suppress(ValueError, RecursionError, TypeError):
            kind, value = json.loads(payload) if payload.count(b",") <= _MOST else ("", None)
            if kind in ("value", "error", "note") and number == self._number:
                return kind, value
        self.close()
        raise RemoteError("it sent what answers no call")

    def _check_printed(self, most: int | None) -> None:
        if most is not None and self.printed > most:
            self.close()
            raise PrintedTooMuchError(f"printed more than {most / 1e6:g} MB")

    def _check_state(self, memory: int | None) -> None:
        """End a process that has grown too large, and detect one that has ended silently."""
        held = self._look()
        if held is None:  # a fork that still holds the channel hides its end
            raise self._died_error()
        if held < 0:
            self.close()
            raise TooManyProcessesError(f"it started more than {tree.MANY:,} processes")
        if memory is not None and held > memory:
            self.close()
            raise MemoryExceededError(
                f"it held {held / 1e6:,.0f} MB of memory, where {memory / 1e6:,.0f} MB are allowed"
            )

    def _look(self) -> int | None:
        """Return the state of this process (:func:`bench.sandbox.tree.look`)."""
        if self._original is not None:
            return self._original._request("look", self._pid)
        process = self._process
        return None if process is None or process.poll() is not None else tree.look(process.pid)

    def _died_error(self) -> DiedError:
        code = self._end(_GRACE)
        tail = os.pread(self._output.fileno(), _TAIL, max(0, self.printed - _TAIL))
        self._output.close()
        return DiedError(UNANSWERABLE if code is None else code, end_of_output(tail))

    def _request(self, request: str, *arguments: object, files: Sequence[int] = ()) -> int | None:
        """Return the answer of this process, which others are forked from, to a request.

        Raises:
            LostError: when it has ended, or does not answer. It is not asked again.
            RemoteError: when plug-in code in it answers in its place; it is ended.
        """
        self._number += 1
        message = None
        if not self._lost:
            with suppress(BrokenChannelError):
                self._channel.send(self._number, pickle.dumps((request, *arguments)), files, _ANSWER)
                message = self._channel.receive(_ANSWER)
        if message is None:
            self._lost = True
            if self._original is None:  # otherwise its own original may have been stopped too
                self.close()
            raise LostError("the process that forks and ends others was itself ended or stopped")
        answer = self._load(*message)[1]
        if answer is not None and type(answer) is not int:
            self.close()
            raise RemoteError("it sent what answers no call")
        return answer

    def _end(self, seconds: float = 0.0) -> int | None:
        """End the process; return its exit code, None where it did not end by itself within ``seconds``."""
        ended, self._closed = self.closed, True
        try:
            if ended:
                return None
            if self._original is not None:
                return self._original._request("end", self._pid, seconds)
            return self._end_process(seconds)
        finally:
            self._channel.close()

    def _end_process(self, seconds: float) -> int | None:
        process = self._process
        if process is None:
            return None
        with suppress(subprocess.TimeoutExpired):
            process.wait(seconds)
        code = process.returncode
        tree.kill(process.pid)
        with suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
        with suppress(OSError):
            process.kill()
        with suppress(subprocess.TimeoutExpired):  # a process that waits for a dead disk cannot be ended
            process.wait(_ANSWER)
        return code


def _let_go(channel: Channel, output: IO[bytes]) -> None:
    with suppress(OSError):
        output.close()
        channel.close()
