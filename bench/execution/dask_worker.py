"""The dask backend, the workers' side: make a trial for as long as the parent waits for it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from math import inf
from threading import Lock, Thread, get_ident
from time import monotonic, sleep

from bench.execution import supervisor
from bench.execution.pool import Answer
from bench.execution.supervisor import Task
from bench.trial import Trial

LOOK = 1.0  # seconds between looks at the state of tasks
IDLE = 60.0  # seconds after which idle trial processes end


def work(task: Task, trial: Trial) -> Answer:
    """Have one trial made by this thread's trial process, for as long as the parent waits for it.

    Dask cannot interrupt a thread. When the parent has released the trial, was killed or has lost the scheduler, this
    module ends the trial's process. It also ends processes that have been idle for a while.

    Raises:
        CancelledError: when the parent no longer waits.
        BenchError: as :func:`bench.execution.supervisor.work`.
    """
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def is_wanted() -> bool:
        state = worker.state.tasks.get(key)
        return state is not None and state.state == "executing"

    _threads.begin(is_wanted)
    try:
        return supervisor.work(task, trial)
    finally:
        _threads.end()


def release() -> None:
    """End the trial processes of this worker soon, unless they get more work."""
    _threads.release()


class _Threads:
    """The threads of this worker that have a trial made, and the watch over them."""

    def __init__(self) -> None:
        self._lock, self._busy, self._used = Lock(), dict[int, Callable[[], bool]](), 0.0
        self._looking = False

    def begin(self, is_wanted: Callable[[], bool]) -> None:
        """Register this thread as busy."""
        with self._lock:
            if not is_wanted():
                raise CancelledError
            self._busy[get_ident()] = is_wanted
            if not self._looking:
                self._looking = True
                Thread(target=self._look, daemon=True).start()

    def end(self) -> None:
        """Register this thread as idle."""
        with self._lock:
            del self._busy[get_ident()]
            self._used = monotonic()

    def release(self) -> None:
        """Let idle trial processes end without waiting ``IDLE`` seconds."""
        self._used = -inf

    def _look(self) -> None:
        """End trial processes that nobody waits for; return when all threads have been idle for a while."""
        while self._looking:
            sleep(LOOK)
            with self._lock:
                if self._busy:
                    if not any(is_wanted() for is_wanted in self._busy.values()):
                        supervisor.close()  # repeated, as a trial whose process is killed is begun once more
                elif monotonic() - self._used > IDLE:
                    supervisor.close()
                    self._looking = False


_threads = _Threads()
