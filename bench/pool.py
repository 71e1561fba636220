"""Where trials are made: on this machine by loky's processes, or on a cluster by dask's workers."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from joblib import Parallel, cpu_count, delayed, parallel_config
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from bench import guard
from bench.errors import BenchError, nearest
from bench.guard import Task
from bench.study import Trial
from bench.worker import Row

BACKENDS = ("dask", "loky")
DEATHS = 3  # of workers in a row, without a trial between them, before a run gives up

Answer = tuple[Trial, Row, str]


class WorkerDiedError(RuntimeError):
    """Worker processes end again and again, whatever they are given; what was finished is kept."""


class Pool:
    """Workers that make trials.

    Attributes:
        jobs: how many trials are made at a time.
        work: what a worker is asked to call.
        window: batches of trials that are under way at a time, of which all but ``jobs`` wait.
        deaths: what is raised when a worker ends in mid-work.
    """

    work: Callable[[Task, Trial], Answer] = staticmethod(guard.work)
    deaths: tuple[type[Exception], ...] = (BrokenProcessPool,)

    def __init__(self, jobs: int, backend: Any) -> None:
        self.jobs, self.window = jobs, 3 * jobs
        self._backend = backend

    def answers(self, task: Task, missing: Callable[[], Iterable[Trial]]) -> Iterator[Answer]:
        """Yield each trial with its row and its machine as workers finish, in any order.

        A worker that is killed costs nothing but time: what was under way is begun again.

        Args:
            task: what the trials have in common.
            missing: returns the trials that are not finished yet.

        Raises:
            WorkerDiedError: when workers end again and again.
            BenchError: for workers that cannot be used.
        """
        deaths = 0
        while True:
            try:
                for answer in self._map(task, missing()):
                    deaths = 0
                    yield answer
                return
            except self.deaths as error:
                deaths += 1
                if deaths == DEATHS:
                    raise WorkerDiedError(
                        f"{DEATHS} worker processes in a row were killed before they had made a trial (is the machine "
                        "short of memory?); every finished trial is kept: run the same command again to continue"
                    ) from error

    def _map(self, task: Task, trials: Iterable[Trial]) -> Iterator[Answer]:
        """Yield answers until there are no more trials; short trials travel in batches."""
        with parallel_config(n_jobs=self.jobs, backend=self._backend):
            self._start()
            parallel = Parallel(return_as="generator_unordered", batch_size="auto", pre_dispatch=self.window)
            yield from parallel(delayed(self.work)(task, trial) for trial in trials)

    def _start(self) -> None:
        """Start what must be there before the first trial."""


class Loky(Pool):
    """Processes on this machine."""

    def _start(self) -> None:
        # Workers that inherit a blocked Ctrl-C are deaf to it from the first: it is the parent's to answer.
        with _held(signal.SIGINT):
            Parallel()([delayed(abs)(0)])


@contextmanager
def open_pool(backend: str, jobs: int, scheduler: str | None) -> Iterator[Pool]:
    """Yield the workers of a backend; they end with the context.

    Args:
        backend: "loky" or "dask".
        jobs: worker processes of loky; -1 takes every core.
        scheduler: the address of dask's scheduler.

    Raises:
        BenchError: for an unknown backend, a scheduler that is missing or cannot be reached, or workers that differ.
    """
    if backend not in BACKENDS:
        raise BenchError(f"unknown backend {backend!r}{nearest(backend, BACKENDS)}")
    if (backend == "dask") != (scheduler is not None):
        raise BenchError("the dask backend needs --scheduler tcp://HOST:PORT, and no other backend takes one")
    if scheduler is not None:
        from bench.cluster import cluster

        with cluster(scheduler) as pool:
            yield pool
        return
    try:
        yield Loky(cpu_count() if jobs == -1 else jobs, backend="loky")
    finally:
        guard.close()  # a single job is made in this process
        if jobs != 1:
            with suppress(Exception):
                get_reusable_executor().shutdown(wait=True, kill_workers=True)


@contextmanager
def _held(number: int) -> Iterator[None]:
    """Hold a signal back; processes that are started meanwhile never see it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
