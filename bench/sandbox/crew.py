"""Call functions side by side, in processes that end with the crew."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from types import TracebackType
from typing import Any

from joblib import cpu_count

from bench.sandbox.process import LostError, Process


class Crew:
    """A thread a job, each with a process of its own that makes one call after the other.

    Args:
        jobs: calls made at a time, -1 for one a core.
        ready: a function that takes and returns nothing; every process calls it first, and has then loaded its module.
    """

    def __init__(self, jobs: int, ready: Callable[[], None]) -> None:
        self._ready = ready
        self._threads = ThreadPoolExecutor(cpu_count() if jobs == -1 else jobs)
        self._own = _Own()
        self._lock = threading.Lock()
        self._started: list[Process] = []
        self._closed = False

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def submit(
        self,
        group: Hashable,
        function: Callable[..., Any],
        *arguments: Any,
        printed: int | None = None,
        seconds: float | None = None,
    ) -> Future[Any]:
        """Have a function called when its turn comes, within limits; see :meth:`bench.sandbox.process.Process.call`.

        A process calls functions of one group only, and is replaced after any error.
        """
        return self._threads.submit(self._call, group, function, arguments, {"printed": printed, "seconds": seconds})

    def close(self) -> None:
        """End all processes; calls that have not begun are cancelled, the others end with an error."""
        with self._lock:
            self._closed = True
        self._threads.shutdown(wait=False, cancel_futures=True)
        for each in self._started:
            each.kill()
        self._threads.shutdown()
        for each in self._started:
            _end(each)

    def _call(
        self, group: Hashable, function: Callable[..., Any], arguments: tuple[Any, ...], limits: dict[str, Any]
    ) -> Any:
        own = self._own
        try:
            if own.template is None:
                own.template = self._start(lambda: Process(0, forks=True))
                own.template.call(self._ready)
            if own.process is None or own.group != group:
                _end(own.process)
                own.process, own.group = self._start(own.template.fork), group
            return own.process.call(function, *arguments, **limits)
        except BaseException as error:
            _end(own.process)
            own.process = None
            if isinstance(error, LostError):  # no other error says anything of the template
                _end(own.template)
                own.template = None
            raise

    def _start(self, start: Callable[[], Process]) -> Process:
        with self._lock:
            if self._closed:
                raise LostError("its crew was closed")
            process = start()
            self._started.append(process)
            return process


class _Own(threading.local):
    """A thread's processes: a template that no plug-in runs in, and a copy of it for the calls of a group."""

    template: Process | None = None
    process: Process | None = None
    group: Hashable = None


def _end(process: Process | None) -> None:
    with suppress(LostError):  # its template has ended, and this process with it
        if process is not None:
            process.close()
