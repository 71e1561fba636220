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
from collections.abc import Callable, Sequence
from contextlib import suppress
from math import inf
from time import monotonic
from types import TracebackType
from typing import Any

from bench.sandbox.channel import BrokenChannelError, Channel
from bench.sandbox.messages import end_of_output
from bench.sandbox.server import FORKS, UNANSWERABLE

# Before any import the channel is all that a process has of its owner: prints go to a file.
_START = """
import json, sys
sys.path[:], end, owner, forks = json.loads(sys.argv.pop())
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

_LOOK = 0.2  # seconds between looks at a busy process: is it alive, how much memory does it hold, has it printed?
_GRACE = 0.5  # seconds for a process that has closed its channel to end
_ANSWER = 10.0  # seconds for a template, which waits for nothing but requests, to answer one
_MOST = 1_000_000  # values of an answer; a message of empty ones takes 25 times its size of memory
_TAIL = 1 << 15  # bytes read of the output: a crash prints 100 frames and all extension modules


class TimeExceededError(RuntimeError):
    """The call took longer than allowed."""


class MemoryExceededError(RuntimeError):
    """The process and those it started held more memory than allowed; the message states how much."""


class PrintedTooMuchError(RuntimeError):
    """The process printed more than allowed."""


class LostError(RuntimeError):
    """The process that forks and ends this one has ended, or answers no more."""


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
    """The function called raised an exception, which the message describes, or gave an answer that is no JSON."""


class Process:
    """A Python process that calls functions of importable modules, one after another, and forks copies of itself.

    It ends at the latest with the process that started it. One thread at a time may use a process or its copies. Where
    processes cannot fork, or one runs threads, a copy is a new process in which the same calls are made again.

    Args:
        hash_seed: its PYTHONHASHSEED, which orders sets of strings.
        forks: whether it is there to be forked rather than to run plug-in code for long.
        command: the words to put before its own command line, such as those of a sandbox.
    """

    _process: subprocess.Popen[bytes] | None

    def __init__(self, hash_seed: int, *, forks: bool = False, command: Sequence[str] = ()) -> None:
        own, other = socket.socketpair()
        self._set_up(own, tempfile.TemporaryFile())  # noqa: SIM115 - closed with the process
        self._start_again = (hash_seed, command)
        self._calls: list[tuple[tuple[Any, ...], dict[str, Any]]] = []  # with their limits, for copies without a fork
        share = hasattr(other, "share")  # on Windows
        owner = 0 if command else os.getpid()  # a sandbox ends with its owner by itself
        given = json.dumps([[str(each) for each in sys.path], "" if share else other.fileno(), owner, forks])
        environment = {"PYTHONHASHSEED": str(hash_seed), "PYTHONIOENCODING": "utf-8"}
        with other:
            process = subprocess.Popen(
                [*command, sys.executable, "-c", _START, given], env=os.environ | _ONE_THREAD | environment,
                stdin=subprocess.PIPE if share else subprocess.DEVNULL, stdout=self._output, stderr=self._output,
                pass_fds=() if share else [other.fileno()], start_new_session=hasattr(os, "killpg"),
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )  # fmt: skip
            self._process = process
            if share and process.stdin is not None:
                with process.stdin as pipe:
                    pipe.write(other.share(process.pid))  # type: ignore[attr-defined]

    def _set_up(self, own: socket.socket, output: Any) -> None:
        self._channel, self._output = Channel(own), output
        self._template: Process | None = None  # that this process was forked from
        self._process = None
        self._pid = self._number = 0
        self._parent: Process | None = None  # that this process is a copy of
        self._copies: set[Process] = set()  # that have not been closed
        self._closed = self._lost = self._killed = False
        self._begun: tuple[Any, ...] = ()
        self.note: Any = None  # the last one of the present call (bench.sandbox.server.note)

    def __enter__(self) -> Process:
        return self

    def __del__(self) -> None:
        with suppress(Exception):  # of one that ended with its template and was never closed
            self._output.close()
            self._channel.close()

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @property
    def closed(self) -> bool:
        """Whether the process was closed, or ended after an error."""
        return self._closed

    @property
    def alive(self) -> bool:
        """Whether the process has neither been closed nor ended by itself."""
        return not self._closed and self._resident() is not None

    @property
    def printed(self) -> int:
        """Bytes written to standard output and error since the last call began."""
        return os.fstat(self._output.fileno()).st_size

    def fork(self) -> Process:
        """Return a copy of this process; it ends with this one.

        Raises:
            LostError: when this process has ended, or does not answer.
            RemoteError: when plug-in code answers in its place.
            The others of :meth:`call`: where the copy is a new process that makes the same calls.
        """
        copy = self._forked() if FORKS else None
        if copy is not None:
            return copy
        hash_seed, command = self._start_again
        copy = Process(hash_seed, command=command)
        self._adopt(copy)
        for call, limits in self._calls:
            copy.call(*call, **limits)
        return copy

    def _forked(self) -> Process | None:
        """Return a copy, None where this process runs threads."""
        own, other = socket.socketpair()
        output = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
        with other:
            pid = self._request("fork", files=(other.fileno(), output.fileno()))
        if pid is None or pid <= 0:
            own.close()
            output.close()
            return None
        copy = object.__new__(Process)
        copy._set_up(own, output)
        copy._template, copy._pid = self, pid
        copy._calls, copy._start_again = [*self._calls], self._start_again
        self._adopt(copy)
        return copy

    def _adopt(self, copy: Process) -> None:
        """Have a copy end with this process, whether the kernel sees to that or not."""
        copy._parent = self
        self._copies.add(copy)
        if self._killed:  # by another thread, which may not have seen the copy
            copy.kill()

    def call(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        seconds: float | None = None,
        silence: float | None = None,
        memory: int | None = None,
        printed: int | None = None,
        again: bool = True,
    ) -> Any:
        """Call a function of an importable module in the process and return its answer, of which JSON is made.

        The arguments are pickled; the answer is not. After any error but a RemoteError the process is ended.

        Args:
            function: what to call.
            arguments: its arguments, picklable.
            seconds: that the call may take; None for no limit.
            silence: seconds that it may take without a note (:func:`bench.sandbox.server.note`); None for no limit.
            memory: bytes that the process and all that it started may hold; None for no limit.
            printed: bytes that the call may print; None for no limit.
            again: whether a copy that cannot be forked makes the call too, within the same limits.

        Raises:
            TimeExceededError, MemoryExceededError, PrintedTooMuchError: when the call exceeded a limit.
            DiedError: when the process ended first.
            LostError: when it was ended before, or the process that forked it has ended, or does not answer.
            RemoteError: when the function raised, or its answer is no JSON.
        """
        self.start(function, *arguments)
        return self.finish(seconds=seconds, silence=silence, memory=memory, printed=printed, again=again)

    def start(self, function: Callable[..., Any], *arguments: Any, files: Sequence[int] = ()) -> None:
        """Begin a call, whose answer :meth:`finish` returns; open files are passed on as further arguments.

        Raises:
            LostError: when the process has been closed, or was ended after an error.
        """
        if self._closed:
            raise LostError("it has been ended")
        self.note = None
        if self.printed:
            self._output.truncate(0)
            self._output.seek(0)
        self._number += 1
        self._begun = (function, *arguments)
        with suppress(BrokenChannelError):  # finish() finds that the process has ended
            self._channel.send(self._number, pickle.dumps(("call", function, *arguments)), files, _ANSWER)

    def finish(
        self,
        *,
        seconds: float | None = None,
        silence: float | None = None,
        memory: int | None = None,
        printed: int | None = None,
        again: bool = True,
    ) -> Any:
        """Return the answer to the call begun by :meth:`start`; see :meth:`call`."""
        now = monotonic()
        end, look = now + (inf if seconds is None else seconds), now + _LOOK
        until = min(end, now + (inf if silence is None else silence))
        while True:
            try:
                message = self._channel.receive(max(0.0, min(look, until) - now))
            except BrokenChannelError:
                raise self._died_error() from None
            now = monotonic()
            if message is not None:
                kind, value = self._load(*message)
                if kind == "value":
                    if printed is not None and self.printed > printed:
                        self.close()
                        raise PrintedTooMuchError
                    if again:
                        limits = {"seconds": seconds, "silence": silence, "memory": memory, "printed": printed}
                        self._calls.append((self._begun, limits))
                    return value
                if kind == "error":
                    raise RemoteError(str(value))
                self.note = value
                until = min(end, now + (inf if silence is None else silence))
            if now >= until:
                self.close()
                raise TimeExceededError(f"{seconds if until == end else silence:g} s")
            if now >= look:
                self._inspect(memory, printed)
                look = monotonic() + _LOOK

    def close(self) -> None:
        """End the process and all that it started, its copies included."""
        try:
            self._end()
        finally:
            self._release()

    def _release(self) -> None:
        """Close the files of an ended process, and of the copies that have ended with it."""
        self._closed = True
        self._channel.close()
        self._output.close()
        for each in self._copies.copy():
            each._release()

    def kill(self) -> None:
        """End a process that was not forked, and its copies; any thread may do so, and its user finds it ended."""
        self._killed = True
        self._end_process(0.0)
        for each in self._copies.copy():
            each.kill()

    def _load(self, number: int, payload: bytes) -> tuple[str, Any]:
        """Return the kind and the value of a message; end a process whose message answers no call."""
        with suppress(ValueError, RecursionError, TypeError):
            kind, value = json.loads(payload) if payload.count(b",") <= _MOST else ("", None)
            if kind in ("value", "error", "note") and number == self._number:
                return kind, value
        self.close()
        raise RemoteError("it sent what answers no call")

    def _inspect(self, memory: int | None, printed: int | None) -> None:
        """End a process that has grown too large or prints too much, and detect one that has ended silently."""
        held = self._resident()
        if held is None:  # a fork that still holds the channel hides its end
            raise self._died_error()
        if memory is not None and held > memory:
            self.close()
            raise MemoryExceededError(
                f"it held {held / 1e6:,.0f} MB of memory, where {memory / 1e6:,.0f} MB are allowed"
            )
        if printed is not None and self.printed > printed:
            self.close()
            raise PrintedTooMuchError

    def _resident(self) -> int | None:
        """Return the bytes that the process and all that it started hold, None where it has ended."""
        if self._template is not None:
            return self._template._request("look", self._pid)
        from bench.sandbox import tree  # not at the top: psutil takes as long to import as all else here

        process = self._process
        return None if process is None or process.poll() is not None else tree.resident(process.pid)

    def _died_error(self) -> DiedError:
        code = self._end(_GRACE)
        tail = os.pread(self._output.fileno(), _TAIL, max(0, self.printed - _TAIL))
        self._output.close()
        return DiedError(UNANSWERABLE if code is None else code, end_of_output(tail))

    def _request(self, request: str, *arguments: Any, files: Sequence[int] = ()) -> int | None:
        """Return a template's answer to a request.

        Raises:
            LostError: when it has ended, or does not answer. It is not asked again.
            RemoteError: when plug-in code in the template answers in its place; it is ended.
        """
        self._number += 1
        message = None
        if not self._lost:
            with suppress(BrokenChannelError, ValueError):  # ValueError: it was closed before
                self._channel.send(self._number, pickle.dumps((request, *arguments)), files, _ANSWER)
                message = self._channel.receive(_ANSWER)
        if message is None:
            self._lost = True
            if self._template is None:  # otherwise its own template may have been stopped too
                self.close()
            raise LostError("the process that forks and ends others was itself ended or stopped")
        answer = self._load(*message)[1]
        if answer is not None and type(answer) is not int:
            self.close()
            raise RemoteError("it sent what answers no call")
        return answer

    def _end(self, seconds: float = 0.0) -> int | None:
        """End the process; return its exit code, None where it did not end by itself within ``seconds``."""
        if self._closed:
            return None
        self._closed = True
        try:
            if self._template is not None:
                return self._template._request("end", self._pid, seconds)
            return self._end_process(seconds)
        finally:
            self._channel.close()
            if self._parent is not None:
                self._parent._copies.discard(self)
            for each in self._copies.copy():
                each.kill()

    def _end_process(self, seconds: float) -> int | None:
        from bench.sandbox import tree

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
