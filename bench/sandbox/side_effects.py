"""Detect what plug-in code has left behind in its process, which then makes no other trial.

This protects the next trial of the same optimizer from accidents; other optimizers run in other processes.
"""

from __future__ import annotations

import _thread
import os
import random
import signal
import sys
import threading
import time
import warnings
from contextlib import suppress

import numpy as np

from bench.contract import seeds
from bench.sandbox.tree import children

_GRACE = 0.1  # seconds for threads and processes to end after their trial
_SIGNALS = [number for number in signal.Signals if number <= 17]  # up to SIGCHLD on Linux; later ones stop processes
_TIMERS = [getattr(signal, name) for name in ("ITIMER_REAL", "ITIMER_VIRTUAL", "ITIMER_PROF") if hasattr(signal, name)]


class SideEffects:
    """A context that runs plug-in code and then holds what the code left behind.

    Attributes:
        random: the global random states that the code used, by name.
        threads: the number of threads that it left running.
        processes: the number of processes that it left running.
        altered: whether the process is otherwise not as it was, as far as that can be detected cheaply.
    """

    def __init__(self) -> None:
        self.random: list[str] = []
        self.threads = self.processes = 0
        self.altered = False

    def __enter__(self) -> SideEffects:
        random.setstate(_PYTHON_STATE)  # which Python itself changes in every fork
        self._threads, self._thread_count = set(threading.enumerate()), _thread_count()
        self._state = _state()
        return self

    def __exit__(self, *_: object) -> None:
        self.altered = _state() != self._state
        deadline = time.monotonic() + _GRACE
        for thread in set(threading.enumerate()) - self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))
        while (left := _thread_count() - self._thread_count) > 0 and time.monotonic() < deadline:
            time.sleep(_GRACE / 100)  # a thread that was waited for takes a moment to leave the system's list
        self.threads = max(0, left)
        self.processes = _left_running(deadline)
        self.random = [name for name, state in seeds.global_states().items() if state != _STATES[name]]

    @property
    def any(self) -> bool:
        """Whether the code left anything behind."""
        return bool(self.altered or self.random or self.threads or self.processes)


def reset_random() -> None:
    """Set the global random states to those that every trial finds, such as after an import that has used them."""
    random.setstate(_PYTHON_STATE)
    np.random.set_state(_NUMPY_STATE)  # noqa: NPY002


def _state() -> tuple[object, ...]:
    """Return the state of the process that a later trial may depend on and that is cheap to compare."""
    return (
        sys.getrecursionlimit(), list(sys.path), len(sys.modules),
        dict(getattr(os.environ, "_data", os.environ)), _folder(), np.geterr(), np.geterrcall(), list(warnings.filters),
        sys.stdin, sys.stdout, sys.stderr, *(_identity(number) for number in range(3)),
        *map(signal.getsignal, _SIGNALS), *map(signal.getitimer, _TIMERS),
        1.0 + _HALF_ULP, 1.0 + 1.5 * _HALF_ULP, _SMALLEST / 2 * 4,  # by the processor's arithmetic modes
    )  # fmt: skip


def _thread_count() -> int:
    """Return the number of threads, those included that have not begun to run: Python does not know them yet."""
    try:
        return len(os.listdir("/proc/self/task"))  # noqa: PTH208 - faster, and called after every trial
    except OSError:
        return _thread._count()


def _folder() -> str:
    with suppress(OSError):  # it may have been removed
        return os.getcwd()  # noqa: PTH109 - faster, and called after every trial
    return ""


def _identity(number: int) -> tuple[int, int] | None:
    with suppress(OSError):
        status = os.fstat(number)
        return status.st_dev, status.st_ino
    return None


def _left_running(deadline: float) -> int:
    """Reap ended child processes; return the number of those that still run at the :func:`time.monotonic` given."""
    if not hasattr(os, "WNOHANG"):
        return 0
    while True:
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return 0  # there is none
        running = len(children() - _resource_trackers())
        if not running or time.monotonic() >= deadline:
            return running
        time.sleep(_GRACE / 10)


def _resource_trackers() -> set[int]:
    """Return the numbers of the helper processes that multiprocessing starts once and keeps."""
    tracker = getattr(sys.modules.get("multiprocessing.resource_tracker"), "_resource_tracker", None)
    loky = getattr(sys.modules.get("joblib.externals.loky.backend.resource_tracker"), "_resource_tracker", None)
    return {pid for helper in (tracker, loky) if isinstance(pid := getattr(helper, "_pid", None), int)}


# Variables, so that the sums are made when they are asked for.
_HALF_ULP, _SMALLEST = float(np.finfo(float).eps) / 2, float(np.finfo(float).smallest_normal)
_PYTHON_STATE, _NUMPY_STATE, _STATES = random.getstate(), np.random.get_state(), seeds.global_states()  # noqa: NPY002
