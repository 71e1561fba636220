"""What strangers' code changes of its process for those after it: put back, or told where it cannot be.

A plug-in is no prisoner here: it is kept from harming others by accident or carelessness, and a process that is not as
it was is given up rather than mended in full.
"""

from __future__ import annotations

import _thread
import builtins
import gc
import math
import os
import random
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from operator import is_
from types import TracebackType
from typing import Any

import numpy as np
import psutil

from bench import objective, seeds, trial

_GRACE = 0.1  # seconds that threads and processes have to end after their trial
_SIGNALS = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM", "SIGUSR1", "SIGUSR2", "SIGCHLD", "SIGPIPE")
    if hasattr(signal, name)
]
_TIMERS = [getattr(signal, name) for name in ("ITIMER_REAL", "ITIMER_VIRTUAL", "ITIMER_PROF") if hasattr(signal, name)]
_SHARED: tuple[Any, ...] = (
    builtins, math, random, time, np, np.random, np.linalg, objective, objective.Objective, seeds, trial,
)  # fmt: skip
"""Namespaces on which everyone's results rest."""


class SideEffects:
    """A context for strangers' code, which holds at its end what the code left behind.

    Attributes:
        random: the global random states that it used, by what they are called.
        threads: how many threads it left running.
        processes: how many processes it left running.
        lasting: whether the process is not as it was, and should make no other trials.
    """

    def __init__(self) -> None:
        self.random: list[str] = []
        self.threads = self.processes = 0
        self.lasting = False

    def __enter__(self) -> SideEffects:
        self._threads, self._thread_count = set(threading.enumerate()), _thread._count()
        self._folder = _folder()
        self._stack = ExitStack()
        self._stack.enter_context(np.errstate())
        self._stack.enter_context(warnings.catch_warnings())
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        _baseline.restore()
        if _folder() != self._folder:
            os.chdir(self._folder)
        self._stack.close()
        deadline = time.monotonic() + _GRACE
        for each in set(threading.enumerate()) - self._threads:
            each.join(max(0.0, deadline - time.monotonic()))
        self.threads = max(0, _thread._count() - self._thread_count)
        self.processes = _left_running(deadline)
        self.random = [name for name, state in seeds.global_states().items() if state != _STATES[name]]
        if self.random:
            _reset_random()
        _baseline.altered |= bool(self.threads or self.processes) or _baseline.changed()
        self.lasting = _baseline.altered


def set_baseline() -> bool:
    """Take the process as it is now for the way it should be, as after an import; return whether it can be.

    It cannot where what others rest on was replaced.
    """
    _reset_random()
    _baseline.altered |= _is_replaced()
    _baseline.record()
    return not _baseline.altered


class _Baseline:
    """The process as it should be.

    Attributes:
        lost: whether it is so no more.
    """

    def __init__(self) -> None:
        self.altered = False
        self.record()

    def record(self) -> None:
        """Take it as it is."""
        self._recursion, self._path, self._path_items = sys.getrecursionlimit(), sys.path, list(sys.path)
        self._tracer = sys.gettrace()
        self._gc = gc.isenabled(), gc.get_threshold()
        self._environment, self._raw_environment = dict(os.environ), dict(_raw_environment())
        self._streams = sys.stdin, sys.stdout, sys.stderr
        self._handlers = {number: signal.getsignal(number) for number in _SIGNALS}
        self._modules = dict(sys.modules)
        self._system_state = _system_state()

    def restore(self) -> None:
        """Undo what can be undone."""
        sys.setrecursionlimit(self._recursion)  # first of all: what follows takes some depth
        if sys.gettrace() is not self._tracer:
            sys.settrace(self._tracer)
        for timer in _TIMERS:
            signal.setitimer(timer, 0)
        if sys.path is not self._path or sys.path != self._path_items:
            sys.path = self._path
            sys.path[:] = self._path_items
        (gc.enable if self._gc[0] else gc.disable)()
        gc.set_threshold(*self._gc[1])
        if _raw_environment() != self._raw_environment:
            os.environ.clear()
            os.environ.update(self._environment)
        sys.stdin, sys.stdout, sys.stderr = self._streams
        with suppress(ValueError, OSError):  # what it printed is its own; a closed stream is seen below
            sys.stdout.flush()
        for number, handler in self._handlers.items():
            if handler is not None and signal.getsignal(number) is not handler:
                signal.signal(number, handler)

    def changed(self) -> bool:
        """Return whether something else is not as it was; modules that were added are taken in."""
        lost = self._modules != sys.modules and _lacks(sys.modules, self._modules)
        if len(self._modules) != len(sys.modules):
            self._modules = dict(sys.modules)
        return lost or self._system_state != _system_state() or _is_replaced()


def _raw_environment() -> Mapping[Any, Any]:
    """Return the environment's variables undecoded: to decode them takes as long as a short trial."""
    found: Mapping[Any, Any] = getattr(os.environ, "_data", os.environ)
    return found


def _reset_random() -> None:
    random.setstate(_PYTHON_STATE)
    np.random.set_state(_NUMPY_STATE)  # noqa: NPY002


def _folder() -> str:
    with suppress(OSError):  # it may have been removed
        return os.getcwd()  # noqa: PTH109 - after every trial, and some are short
    return ""


def _system_state() -> tuple[Any, ...]:
    """Return what the process has from the system: its standard files, limits and priority."""
    files = [_identity(number) for number in range(3)]
    closed = [getattr(stream, "closed", True) for stream in (sys.stdin, sys.stdout, sys.stderr)]
    return (*files, *closed, *(each() for each in _LIMITS))


def _identity(number: int) -> tuple[int, int] | None:
    with suppress(OSError):
        status = os.fstat(number)
        return status.st_dev, status.st_ino
    return None


def _limits() -> list[Callable[[], Any]]:
    """Return functions that tell the process's limits, where the system has such."""
    try:
        import resource
    except ImportError:
        return []
    kinds = [getattr(resource, f"RLIMIT_{name}") for name in ("AS", "CPU", "DATA", "FSIZE", "NOFILE", "STACK")]
    return [lambda: [resource.getrlimit(kind) for kind in kinds], lambda: os.getpriority(os.PRIO_PROCESS, 0)]


def _is_replaced() -> bool:
    """Return whether a function or class that results rest on is another one by now."""
    for namespace, names, seen in _ORIGINALS:
        if vars(namespace) != seen:
            if _lacks(vars(namespace), names):
                return True
            seen.clear()
            seen.update(vars(namespace))  # such as a part of a package that was imported only now
    return False


def _lacks(current: Mapping[str, Any], known: Mapping[str, Any]) -> bool:
    """Return whether a known name is gone or means something else."""
    return not all(map(is_, map(current.get, known), known.values()))


def _left_running(deadline: float) -> int:
    """Return how many processes started from this one run on; multiprocessing's own trackers of resources do not count.

    Those that have ended are buried.
    """
    if not hasattr(os, "WNOHANG"):
        return 0
    while True:
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return 0
        running = sum(map(_counts, psutil.Process().children(recursive=True)))
        if not running or time.monotonic() >= deadline:
            return running
        time.sleep(_GRACE / 10)


def _counts(process: psutil.Process) -> bool:
    with suppress(psutil.Error):
        return process.status() != psutil.STATUS_ZOMBIE and not any("resource_tracker" in w for w in process.cmdline())
    return False


_LIMITS = _limits()
_PYTHON_STATE, _NUMPY_STATE, _STATES = random.getstate(), np.random.get_state(), seeds.global_states()  # noqa: NPY002
_ORIGINALS = [
    (each, {name: value for name, value in vars(each).items() if callable(value)}, dict(vars(each))) for each in _SHARED
]
_baseline = _Baseline()
