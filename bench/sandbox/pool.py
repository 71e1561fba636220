"""Call functions side by side, in processes that end with the pool."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, suppress
from queue import SimpleQueue
from typing import Any

from joblib import cpu_count

from bench.sandbox.bubblewrap import Sandbox
from bench.sandbox.forks import ForkServer
from bench.sandbox.process import LostError, Process, RemoteError

LOADING = 300.0  # seconds for a process to load the modules that it needs


def number(jobs: int) -> int:
    """Return the number of jobs that is meant, where -1 is one for each core."""
    return int(cpu_count()) if jobs == -1 else jobs


class Pool(AbstractContextManager["Pool"]):
    """A thread a job, each with a process of its own that makes one call after the other.

    Args:
        jobs: calls made at a time, -1 for one a core.
        ready: a function that takes and returns nothing; every process calls it first, and has then loaded its module.
        sandbox: in which all processes run; None for none.
    """

    def __init__(self, jobs: int, ready: Callable[[], None], sandbox: Sandbox | None = None) -> None:
        self._workers = [_Worker(ready, sandbox) for _ in range(number(jobs))]
        self._idle: SimpleQueue[_Worker] = SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        self._threads = ThreadPoolExecutor(len(self._workers))

    def __exit__(self, *_: object) -> None:
        self.close()

    def submit(
        self,
        group: Hashable,
        function: Callable[..., Any],
        *arguments: Any,
        seconds: float | None = None,
        **limits: int | None,
    ) -> Future[Any]:
        """Have a function called when its turn comes, within limits; see :meth:`bench.sandbox.process.Process.call`.

        A process calls functions of one group only, and is replaced after any error.
        """
        return self._threads.submit(self._call, group, function, *arguments, seconds=seconds, **limits)

    def close(self) -> None:
        """End all processes; calls that have not begun are cancelled, the others end with an error."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for worker in self._workers:
            worker.server.kill()
        self._threads.shutdown()

    def _call(self, *call: Any, **limits: Any) -> Any:
        worker = self._idle.get()  # there is one for each thread
        try:
            return worker.call(*call, **limits)
        finally:
            self._idle.put(worker)


class _Worker:
    """Makes calls one at a time; its fork server runs no plug-in, its process those of one group."""

    def __init__(self, ready: Callable[[], None], sandbox: Sandbox | None) -> None:
        self.server, self._ready = ForkServer(sandbox=sandbox), ready
        self._process: Process | None = None
        self._group: Hashable = None

    def call(self, group: Hashable, function: Callable[..., Any], *arguments: Any, **limits: Any) -> Any:
        try:
            self.server.ensure(self._ready, seconds=LOADING)
            if self._process is None or self._process.closed or group != self._group:
                with suppress(LostError, RemoteError):  # what it was forked from has ended, and it with that
                    if self._process is not None:
                        self._process.close()
                self._process, self._group = self.server.process(), group
            return self._process.call(function, *arguments, **limits)
        except LostError:  # no other error says anything of the process that it was forked from
            self.server.close()
            raise
