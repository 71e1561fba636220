"""Inside a worker of a dask cluster: make a trial for as long as somebody waits for it."""

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

LOOK = 1.0  # seconds between looks at what is going on
IDLE = 60.0  # seconds after which idle trial processes end


def work(task: Task, trial: Trial) -> Answer:
    """Have one trial made by a process of this thread's own, for as long as somebody waits for it.

    Dask cannot end what a thread is at. When the parent has let go, was killed or has lost the scheduler, the trial's
    process is ended here, and so are those that have had nothing to do for a while.

    Raises:
        CancelledError: when nobody waits.
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
    """End the trial processes of this worker soon, unless there is something to do for them."""
    _threads.release()


class _Threads:
    """What the threads of this worker are at."""

    def __init__(self) -> None:
        self._lock, self._busy, self._used = Lock(), dict[int, Callable[[], bool]](), 0.0
        self._looking = False

    def begin(self, is_wanted: Callable[[], bool]) -> None:
        """Note that this thread has a trial made."""
        with self._lock:
            if not is_wanted():
                raise CancelledError
            self._busy[get_ident()] = is_wanted
            if not self._looking:
                self._looking = True
                Thread(target=self._look, daemon=True).start()

    def end(self) -> None:
        """Note that it is done."""
        with self._lock:
            del self._busy[get_ident()]
            self._used = monotonic()

    def release(self) -> None:
        """Note that there may be no more to do."""
        self._used = -inf

    def _look(self) -> None:
        """End trial processes that nobody waits for, until all threads are idle."""
        while self._looking:
            sleep(LOOK)
            with self._lock:
                if self._busy:
                    if not any(is_wanted() for is_wanted in self._busy.values()):
                        supervisor.close()  # as often as it takes: a trial whose process is killed is begun once more
                elif monotonic() - self._used > IDLE:
                    supervisor.close()
                    self._looking = False


_threads = _Threads()
