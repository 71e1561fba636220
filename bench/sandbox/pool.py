"""Call functions side by side, in processes that end with the pool."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager, suppress
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any

from joblib import Parallel, cpu_count, delayed

from bench.sandbox.forks import ForkServer
from bench.sandbox.process import LostError, Process, RemoteError
from bench.sandbox.signals import signals_delayed

LOADING = 300.0  # seconds for a process to load the modules that it needs


def number(jobs: int) -> int:
    """Return the number of jobs that is meant, where -1 is one for each core."""
    return int(cpu_count()) if jobs == -1 else jobs


@contextmanager
def side_by_side(loops: Sequence[Callable[[], None]], end: Callable[[], None]) -> Iterator[None]:
    """Run functions in threads of their own, which ``end`` has return; they have returned when the context ends."""
    # Of threads that a second interrupt cuts off; joblib may print it whenever it drops them.
    warnings.filterwarnings(
        "ignore", "[0-9]+ tasks (have been successfully executed|which were still being processed)", UserWarning
    )
    with signals_delayed():  # an interrupt while joblib starts threads would leave it in an undefined state
        # With one job joblib would take no thread.
        parallel = Parallel(n_jobs=max(2, len(loops)), backend="threading", return_as="generator_unordered")
        threads = parallel(delayed(each)() for each in loops)
    try:
        yield
    finally:
        end()
        list(threads)


class Pool:
    """A thread a job, each with a process of its own that makes one call after the other.

    Args:
        jobs: calls made at a time, -1 for one a core.
        ready: a function that takes and returns nothing; every process calls it first, and has then loaded its module.
    """

    def __init__(self, jobs: int, ready: Callable[[], None]) -> None:
        self._ready = ready
        self._waiting: SimpleQueue[_Call | None] = SimpleQueue()
        self._servers = [ForkServer() for _ in range(number(jobs))]
        self._closing = ExitStack()
        loops = [lambda each=each: self._work(each) for each in self._servers]
        self._closing.enter_context(side_by_side(loops, self._end))

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def submit(
        self,
        group: Hashable,
        function: Callable[..., Any],
        *arguments: Any,
        seconds: float | None = None,
        printed: int | None = None,
    ) -> Future[Any]:
        """Have a function called when its turn comes, within limits; see :meth:`bench.sandbox.process.Process.call`.

        A process calls functions of one group only, and is replaced after any error.
        """
        call = _Call(group, function, arguments, {"seconds": seconds, "printed": printed})
        self._waiting.put(call)
        return call.future

    def close(self) -> None:
        """End all processes; calls that have not begun are cancelled, the others end with an error."""
        self._closing.close()

    def _end(self) -> None:
        with suppress(Empty):
            while True:
                if call := self._waiting.get_nowait():
                    call.future.cancel()
        for each in self._servers:
            self._waiting.put(None)
            each.kill()

    def _work(self, server: ForkServer) -> None:
        """Make calls until there is a None; the fork server runs no plug-in, its processes those of one group."""
        process, group, ready = None, None, False
        while call := self._waiting.get():
            if not call.future.set_running_or_notify_cancel():
                continue
            try:
                if not ready:
                    server.call(self._ready, seconds=LOADING)
                    ready = True
                if process is None or group != call.group:
                    _close(process)
                    process, group = server.process(), call.group
                call.future.set_result(process.call(call.function, *call.arguments, **call.limits))
            except BaseException as error:
                _close(process)
                process = None
                if isinstance(error, LostError):  # no other error says anything of the process that it was forked from
                    server.close()
                call.future.set_exception(error)


class _Call:
    def __init__(self, group: Hashable, function: Callable[..., Any], arguments: tuple[Any, ...], limits: Any) -> None:
        self.group, self.function, self.arguments, self.limits = group, function, arguments, limits
        self.future: Future[Any] = Future()


def _close(process: Process | None) -> None:
    with suppress(LostError, RemoteError):  # what it was forked from has ended, and it with that
        if process is not None:
            process.close()
