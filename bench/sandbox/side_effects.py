"""Undo the side effects of plug-in code on the trial process, or report those that cannot be undone.

This is no security boundary: it keeps a plug-in from harming other trials by accident. A process that cannot be
restored cheaply is given up.
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

_GRACE = 0.1  # seconds for threads and processes to end after their trial
_SIGNALS = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM", "SIGUSR1", "SIGUSR2", "SIGCHLD", "SIGPIPE")
    if hasattr(signal, name)
]
_TIMERS = [getattr(signal, name) for name in ("ITIMER_REAL", "ITIMER_VIRTUAL", "ITIMER_PROF") if hasattr(signal, name)]
_SHARED: tuple[Any, ...] = (
    builtins, math, random, time, np, np.random, np.linalg, objective, objective.Objective, seeds, trial,
)  # fmt: skip
"""Namespaces that every trial's result depends on."""


class SideEffects:
    """A context that runs plug-in code, restores the process afterwards and records what the code left behind."""

    def __init__(self) -> None:
        self.random: list[str] = []  # the global random states that the code used, by name
        self.threads = self.processes = 0  # left running
        self.lasting = False  # whether the process could not be restored, and must make no other trials

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
    """Record the present state as the one to restore, such as after an import; return whether it is usable.

    It is not where a function or class that results depend on was replaced.
    """
    _reset_random()
    _baseline.altered |= _is_replaced()
    _baseline.record()
    return not _baseline.altered


class _Baseline:
    """The state of the process that every trial starts from."""

    def __init__(self) -> None:
        self.altered = False  # whether the process differs from it for good
        self.record()

    def record(self) -> None:
        """Record the present state."""
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
        sys.setrecursionlimit(self._recursion)  # first, as the calls below need some depth
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
        with suppress(ValueError, OSError):  # its output is no concern here; changed() detects a closed stream
            sys.stdout.flush()
        for number, handler in self._handlers.items():
            if handler is not None and signal.getsignal(number) is not handler:
                signal.signal(number, handler)

    def changed(self) -> bool:
        """Return whether anything that restore() does not undo has changed; added modules become part of the state."""
        lost = self._modules != sys.modules and _lacks(sys.modules, self._modules)
        if len(self._modules) != len(sys.modules):
            self._modules = dict(sys.modules)
        return lost or self._system_state != _system_state() or _is_replaced()


def _raw_environment() -> Mapping[Any, Any]:
    """Return the environment's variables undecoded: decoding them takes as long as a short trial."""
    found: Mapping[Any, Any] = getattr(os.environ, "_data", os.environ)
    return found


def _reset_random() -> None:
    random.setstate(_PYTHON_STATE)
    np.random.set_state(_NUMPY_STATE)  # noqa: NPY002


def _folder() -> str:
    with suppress(OSError):  # it may have been removed
        return os.getcwd()  # noqa: PTH109 - faster, and called after every trial
    return ""


def _system_state() -> tuple[Any, ...]:
    """Return the state of the process in the system: its standard files, limits and priority."""
    files = [_identity(number) for number in range(3)]
    closed = [getattr(stream, "closed", True) for stream in (sys.stdin, sys.stdout, sys.stderr)]
    return (*files, *closed, *(each() for each in _LIMITS))


def _identity(number: int) -> tuple[int, int] | None:
    with suppress(OSError):
        status = os.fstat(number)
        return status.st_dev, status.st_ino
    return None


def _limits() -> list[Callable[[], Any]]:
    """Return functions that read the process's limits and priority, none where the system has no such limits."""
    try:
        import resource
    except ImportError:
        return []
    kinds = [getattr(resource, f"RLIMIT_{name}") for name in ("AS", "CPU", "DATA", "FSIZE", "NOFILE", "STACK")]
    return [lambda: [resource.getrlimit(kind) for kind in kinds], lambda: os.getpriority(os.PRIO_PROCESS, 0)]


def _is_replaced() -> bool:
    """Return whether a function or class that results depend on has been replaced."""
    for namespace, names, seen in _ORIGINALS:
        if vars(namespace) != seen:
            if _lacks(vars(namespace), names):
                return True
            seen.clear()
            seen.update(vars(namespace))  # such as a submodule that has been imported since
    return False


def _lacks(current: Mapping[str, Any], known: Mapping[str, Any]) -> bool:
    """Return whether a known name is missing or refers to another object."""
    return not all(map(is_, map(current.get, known), known.values()))


def _left_running(deadline: float) -> int:
    """Reap ended child processes; return the number of descendants that still run, without resource trackers.

    They may end until the :func:`time.monotonic` of the deadline.
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
