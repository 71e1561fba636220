"""The loop inside a :class:`bench.sandbox.process.Process`: answer calls, fork copies of itself, end them.

Answers are JSON, so that their receiver never unpickles what plug-in code may have written.
"""

from __future__ import annotations

import faulthandler
import gc
import json
import os
import pickle
import signal
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Thread
from time import monotonic, sleep
from typing import Any

from bench.sandbox.channel import LONGEST, BrokenChannelError, Channel
from bench.sandbox.messages import describe_error
from bench.sandbox.tree import children, kill, resident

FORKS = sys.platform == "linux"
"""Whether processes fork: elsewhere forks are unsafe, or nothing ends a copy together with its original."""

UNANSWERABLE = 88
"""The exit code of a process that cannot answer because the code it called has closed the channel."""

_LOOK = 0.5  # seconds between looks for the owner
_REAP = 5.0  # seconds for killed processes to end
_PAUSE = 0.0005  # seconds between looks for the end of a process

_PR_SET_PDEATHSIG, _PR_SET_DUMPABLE, _PR_SET_CHILD_SUBREAPER = 1, 4, 36  # linux/prctl.h


def serve(end: int, owner: int, forks: bool) -> None:
    """Answer requests until the channel ends.

    Args:
        end: the file number of the channel's socket.
        owner: the number of the process that started this one; 0 where it cannot be seen.
        forks: whether this process is to be forked, so that it may run no thread.
    """
    faulthandler.enable(all_threads=False)
    with suppress(OSError):  # ended first when the machine runs out of memory
        Path("/proc/self/oom_score_adj").write_text("1000")
    _adopt_orphans()
    if not owner:  # in a sandbox no copy may write to the memory of the process that it was forked from
        _prctl(_PR_SET_DUMPABLE, 0)
    if not forks and owner:
        Thread(target=_end_with_owner, args=(owner,), daemon=True).start()
    _Server(Channel(socket.socket(fileno=end), takes_files=hasattr(socket, "recv_fds"))).loop()


def note(value: Any) -> None:
    """Send a note on the progress of the present call to the owner, as JSON; it prolongs no time limit."""
    if _serving is not None:
        _serving.note(value)


class _Server:
    def __init__(self, channel: Channel) -> None:
        self._channel, self._process = channel, os.getpid()
        self._number = 0  # of the present call
        self._called = True  # since the last fork
        self._before: set[int] = set()  # children that calls have left running
        self._copies: set[int] = set()

    def loop(self) -> None:
        global _serving
        _serving = self
        while True:
            try:
                received = self._channel.receive()
            except BrokenChannelError:
                self._end()
            assert received is not None  # no time limit was given
            self._number, payload = received
            try:
                request, *arguments = pickle.loads(payload)
            except BaseException as error:  # of a module that is imported for it
                self._answer(["error", describe_error(error)])
                continue
            if request == "fork":
                answer = self._fork()
                if answer is None:
                    continue  # in the copy
            else:
                answer = (
                    self._call(*arguments) if request == "call" else ["value", _REQUESTS[request](self, *arguments)]
                )
            self._answer(answer)

    def note(self, value: Any) -> None:
        if os.getpid() == self._process:
            self._channel.send(self._number, json.dumps(["note", value]).encode())

    def _answer(self, answer: list[Any]) -> None:
        if os.getpid() != self._process:  # a fork that has returned from its call and arrives here
            os._exit(0)
        try:
            payload = json.dumps(answer).encode()
            if len(payload) > LONGEST:
                payload = json.dumps(["error", f"its answer is too long: {len(payload):,} bytes"]).encode()
        except (TypeError, ValueError, RecursionError) as error:
            payload = json.dumps(["error", f"its answer is no JSON: {describe_error(error)}"]).encode()
        try:
            self._channel.send(self._number, payload)
        except BrokenChannelError:
            os._exit(UNANSWERABLE)

    def _call(self, function: Callable[..., Any], *arguments: Any) -> list[Any]:
        self._called = True
        try:
            answer = ["value", function(*arguments, *self._take_files())]
        except BaseException as error:  # a plug-in may raise KeyboardInterrupt or GeneratorExit too
            answer = ["error", describe_error(error)]
        for stream in (sys.stdout, sys.stderr):
            with suppress(Exception):  # closed, or replaced by anything
                stream.flush()
        return answer

    def _take_files(self) -> list[int]:
        files, self._channel.files = self._channel.files, []
        return files

    def _fork(self) -> list[Any] | None:
        """Fork a copy, which serves the channel and writes to the output that came with the request.

        Return its number, or minus the number of other threads, with which a fork is unsafe; None in the copy.
        """
        end, output = self._take_files()
        threads = len(list(Path("/proc/self/task").iterdir())) - 1
        if threads:
            os.close(end)
            os.close(output)
            return ["value", -threads]
        if self._called:  # a collection in a copy would copy every page that holds an object
            gc.collect()
            gc.freeze()
            self._called = False
            self._before = children() - self._copies
        pid = os.fork()
        if pid:
            self._copies.add(pid)
            os.close(end)
            os.close(output)
            return ["value", pid]
        _end_with_template(self._process)
        os.setsid()
        self._channel.close()
        self._channel, self._process = Channel(socket.socket(fileno=end), takes_files=True), os.getpid()
        self._before, self._copies = set(), set()
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.close(output)
        return None

    def _end_copy(self, pid: int, seconds: float) -> int | None:
        """End a copy and all that it started; return its exit code, None where it had to be ended after ``seconds``.

        After a signal the code is minus the signal's number.
        """
        code = _reap(pid, seconds)
        with suppress(OSError):
            os.killpg(pid, signal.SIGKILL)
        with suppress(OSError):
            if code is None:
                os.kill(pid, signal.SIGKILL)
                _reap(pid, _REAP)
        self._copies.discard(pid)
        until = monotonic() + _REAP
        while (strays := children() - self._before - self._copies) and monotonic() < until:
            for each in strays:
                with suppress(OSError):
                    os.kill(each, signal.SIGKILL)
                _reap(each, _PAUSE)
        return code

    def _end(self) -> None:
        """End this process and all that it and its copies started: the owner has ended."""
        kill(os.getpid())
        os._exit(1)


_REQUESTS: dict[str, Callable[..., int | None]] = {
    "end": _Server._end_copy,
    "look": lambda _, pid: resident(pid),
}


def _reap(pid: int, seconds: float) -> int | None:
    """Return the exit code of a child that ends within ``seconds``, else None."""
    until = monotonic() + seconds
    while True:
        try:
            ended, status = os.waitpid(pid, os.WNOHANG)
        except ChildProcessError:
            return UNANSWERABLE  # no longer a child: someone else has waited for it
        if ended:
            return os.waitstatus_to_exitcode(status)
        if monotonic() >= until:
            return None
        sleep(_PAUSE)


def _end_with_owner(owner: int) -> None:
    """End this process and its group when the owner has ended, even in mid-call."""
    while os.getppid() == owner:
        sleep(_LOOK)
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def _prctl(option: int, value: int) -> None:
    if _system is not None:
        _system.prctl(option, _number(value))


def _adopt_orphans() -> None:
    """Have the kernel make orphans of this process's tree its children, so that they are found and ended."""
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)


def _end_with_template(template: int) -> None:
    """Have the kernel end this process with the one that forked it, even in native code."""
    _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    _adopt_orphans()
    if os.getppid() != template:  # it has ended meanwhile
        os._exit(1)


_serving: _Server | None = None
_system: Any = None
if FORKS:
    from ctypes import CDLL
    from ctypes import c_ulong as _number

    _system = CDLL(None)
