"""The loop inside a :class:`bench.sandbox.process.Process`: answer calls until the owner ends."""

from __future__ import annotations

import faulthandler
import os
import pickle
import signal
import struct
import sys
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from threading import Lock, Thread
from time import monotonic

from bench.sandbox.messages import describe_error

UNANSWERABLE = 88
"""The exit code of a process that cannot answer because the code it called has closed the pipe."""

_HEAD = struct.Struct("<QQ")  # the call's number, and the number of bytes that follow
_CHUNK = 1 << 20
_PULSE = 0.5  # seconds between pulses that are sent

_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36  # linux/prctl.h


def send(pipe: int, number: int, payload: bytes) -> None:
    """Write a payload that belongs to the call of this number."""
    rest = memoryview(_HEAD.pack(number, len(payload)) + payload)
    while rest:
        rest = rest[os.write(pipe, rest) :]


def receive(pipe: int) -> tuple[int, bytes]:
    """Read what :func:`send` wrote; raises EOFError at the end of the pipe."""
    number, length = _HEAD.unpack(_read(pipe, _HEAD.size))
    return number, _read(pipe, length)


def _read(pipe: int, length: int) -> bytes:
    read = bytearray()
    while len(read) < length:
        chunk = os.read(pipe, min(length - len(read), _CHUNK))
        if not chunk:
            raise EOFError
        read += chunk
    return bytes(read)


def serve(calls: int, answers: int, owner: int) -> None:
    """Answer calls until the pipe of calls ends.

    Args:
        calls: the pipe of calls; this process ends with it.
        answers: the pipe of answers and pulses.
        owner: the number of the process whose main thread started this one; 0 where another thread did.
    """
    faulthandler.enable(all_threads=False)
    _end_with_owner(owner)
    channel, made = _Channel(answers), SimpleQueue[tuple[int, bytes]]()
    Thread(target=_listen, args=(calls, made), daemon=True).start()
    while True:  # in the main thread, where plug-ins expect to be imported and run
        number, call = made.get()
        channel.answer(number, _answer(call, _Pulse(channel, number)))


def _answer(call: bytes, pulse: _Pulse) -> bytes:
    try:
        function, arguments = pickle.loads(call)
        return pickle.dumps(("answer", function(*arguments, pulse=pulse)))
    except BaseException as error:  # a plug-in may raise KeyboardInterrupt or GeneratorExit too
        return pickle.dumps(("error", describe_error(error)))


def _end_with_owner(owner: int) -> None:
    """Have the kernel end this process with its owner, even in native code, and first where memory runs out."""
    with suppress(OSError):  # ended first when the machine runs out of memory
        Path("/proc/self/oom_score_adj").write_text("1000")
    if sys.platform != "linux":
        return
    import ctypes

    prctl = ctypes.CDLL(None).prctl
    prctl(_PR_SET_CHILD_SUBREAPER, ctypes.c_ulong(1))  # adopts orphans, so that they are found and ended
    if owner:  # the kernel signals at the end of the starting thread, so that must be the last thread to end
        prctl(_PR_SET_PDEATHSIG, ctypes.c_ulong(signal.SIGKILL))
        if os.getppid() != owner:  # the owner has ended meanwhile
            os._exit(1)


def _listen(calls: int, made: SimpleQueue[tuple[int, bytes]]) -> None:
    """Receive calls; at the end of the pipe (the owner has ended) end this process and its group, even in mid-call."""
    with suppress(EOFError, OSError):
        while True:
            made.put(receive(calls))
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


class _Channel:
    """Sends answers and pulses to the owner; refuses to send from forks, which inherit the pipe."""

    def __init__(self, pipe: int) -> None:
        self._pipe, self._process, self._lock = pipe, os.getpid(), Lock()

    def answer(self, number: int, payload: bytes) -> None:
        """Send an answer; end a fork that has returned from its call and arrives here."""
        if os.getpid() != self._process:
            os._exit(0)
        try:
            self.write(number, payload)
        except OSError:
            os._exit(UNANSWERABLE)

    def write(self, number: int, payload: bytes) -> None:
        """Send a payload; safe to call from any thread."""
        if os.getpid() == self._process:
            with self._lock:
                send(self._pipe, number, payload)


class _Pulse:
    """Sends the evaluations made, at most every half second and at the budget's end."""

    def __init__(self, channel: _Channel, number: int) -> None:
        self._channel, self._number, self._next = channel, number, 0.0

    def __call__(self, made: int, budget: int) -> None:
        if made == budget or monotonic() >= self._next:
            self._next = monotonic() + _PULSE
            self._channel.write(self._number, pickle.dumps(("pulse", (int(made), int(budget)))))
