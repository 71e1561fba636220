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

from bench.sandbox import namespaces
from bench.sandbox.channel import LONGEST, BrokenChannelError, Channel
from bench.sandbox.messages import describe_error
from bench.sandbox.tree import children, kill, look

FORKS = sys.platform == "linux"
"""Whether processes fork: elsewhere forks are unsafe, or nothing ends a copy together with its original."""

STILL_ASKING = 87
"""The exit code of a process whose optimizer kept asking for values after its budget was spent."""

UNANSWERABLE = 88
"""The exit code of a process that cannot answer because the code it called has closed the channel."""

_REFUSALS = 10_000  # of values after the end of the budget; one suffices for an optimizer that lets it pass

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
    _Server(Channel(socket.socket(fileno=end), takes_files=hasattr(socket, "recv_fds")), apart=not owner).loop()


def note(value: object) -> None:
    """Send a note on the progress of the present call to the owner, as JSON; it prolongs no time limit."""
    if _serving is not None:
        _serving.note(value)


def end_if_stuck(refusals: int) -> None:
    """End this process where an optimizer keeps asking for values after its budget is spent: nothing else stops it."""
    if _serving is not None and refusals > _REFUSALS:
        os._exit(STILL_ASKING)


class _Server:
    def __init__(self, channel: Channel, *, apart: bool) -> None:
        self._channel, self._process = channel, os.getpid()
        self._apart = apart  # whether this is a sandbox, so that copies have namespaces of their own
        self._number = 0  # of the present call
        self._before: set[int] = set()  # children that calls have left running
        self._copies: dict[int, int] = {}  # with their numbers in /proc, which may be that of other namespaces

    def loop(self) -> None:
        global _serving
        _serving = self
        while True:
            try:
                received = self._channel.receive()
            except BrokenChannelError:  # the owner has ended: end this process, and all that it and its copies started
                kill(os.getpid())
                os._exit(1)
            assert received is not None  # no time limit was given
            self._number, payload = received
            try:
                request, *arguments = pickle.loads(payload)
            except BaseException as error:  # of a module that is imported for it
                self._answer(["error", describe_error(error)])
                continue
            if (answer := getattr(self, f"_{request}")(*arguments)) is not None:  # None in the copy
                self._answer(answer)

    def note(self, value: object) -> None:
        if os.getpid() == self._process:
            self._channel.send(self._number, json.dumps(["note", value]).encode())

    def _answer(self, answer: list[object]) -> None:
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

    def _call(self, function: Callable[..., object], *arguments: object) -> list[object]:
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

    def _fork(self) -> list[object] | None:
        """Fork a copy, which serves the channel and writes to the output that came with the request.

        Returns:
            Its number, or 0 where a fork is unsafe, as this process runs other threads, or would share with others of
            its kind what namespaces do not keep apart; None in the copy.
        """
        end, output = files = self._take_files()
        pid = 0
        if len(os.listdir("/proc/self/task")) == 1 and not (self._apart and namespaces.shares(own=6)):  # noqa: PTH208
            gc.freeze()  # a collection in a copy would copy every page that holds an object
            before = children()
            self._before |= before - {*self._copies.values()}
            pid = os.fork()
            if not pid:
                self._begin_copy(end, output)
                return None
            self._copies[pid] = max(children() - before, default=pid) if self._apart else pid
        for file in files:
            os.close(file)
        return ["value", pid]

    def _begin_copy(self, end: int, output: int) -> None:
        """Turn this process, which has just been forked, into a server of its own."""
        _end_with_original(self._process)
        os.setsid()
        if self._apart and (inside := namespaces.enter()):
            self._channel.close()
            _stand_for(inside, self._process, end, output)
        if self._apart:
            _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
            _adopt_orphans()
        self._channel.close()
        self._channel, self._process = Channel(socket.socket(fileno=end), takes_files=True), os.getpid()
        self._before, self._copies = set(), {}
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.close(output)

    def _look(self, pid: int) -> list[object]:
        return ["value", look(self._copies.get(pid, 0))]

    def _end(self, pid: int, seconds: float) -> list[object]:
        """End a copy and all that it started; return its exit code, None where it had to be ended after ``seconds``.

        After a signal the code is minus the signal's number.
        """
        if pid not in self._copies:  # plug-in code may have answered in place of a fork
            return ["value", None]
        code = _reap(pid, seconds)
        with suppress(OSError):
            os.killpg(pid, signal.SIGKILL)
        with suppress(OSError):
            if code is None:
                os.kill(pid, signal.SIGKILL)
                _reap(pid, _REAP)
        del self._copies[pid]
        if self._process == 1:  # of its own namespaces: those of the copy have ended with it
            self._reap_orphans()
            return ["value", code]
        until = monotonic() + _REAP
        while (strays := children() - self._before - {*self._copies.values()}) and monotonic() < until:
            for stray in strays:
                with suppress(OSError):
                    os.kill(stray, signal.SIGKILL)
                _reap(stray, _PAUSE)
        return ["value", code]

    def _reap_orphans(self) -> None:
        """Wait for adopted processes that have ended, such as the first one of a copy's namespaces, until a copy has.

        At most those that are ending right now stay until the next time.
        """
        with suppress(ChildProcessError):
            while ended := os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT):
                if ended.si_pid in self._copies:  # its code is asked for later
                    return
                os.waitpid(ended.si_pid, 0)


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


def _stand_for(inside: int, original: int, *files: int) -> None:
    """Wait for the first process of other namespaces, and end with its code; it ends with this one."""
    _end_with_original(original)  # once more, as other namespaces may undo it
    for file in files:
        os.close(file)
    code = os.waitstatus_to_exitcode(os.waitpid(inside, 0)[1])
    os._exit(code if code >= 0 else 128 - code)


def _end_with_original(original: int) -> None:
    """Have the kernel end this process with the one that forked it, even in native code."""
    _prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    _adopt_orphans()
    if os.getppid() != original:  # it has ended meanwhile
        os._exit(1)


_serving: _Server | None = None
_system: Any = None
if FORKS:
    from ctypes import CDLL
    from ctypes import c_ulong as _number

    _system = CDLL(None)
