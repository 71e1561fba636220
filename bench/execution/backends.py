"""Open the workers of a backend: loky's processes on this machine, or a dask cluster."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from multiprocessing import resource_tracker
from time import sleep

from joblib import Parallel, cpu_count, delayed
from joblib.externals.loky import reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from bench.errors import BenchError, nearest
from bench.execution import supervisor
from bench.execution.pool import Pool

BACKENDS = ("dask", "loky")
FEEDING = 5.0  # seconds for a thread that feeds workers to notice that they have ended


def open_pool(backend: str, jobs: int, scheduler: str | None) -> AbstractContextManager[Pool]:
    """Return a context that yields the workers of a backend and ends them: ``jobs`` of loky, or all of a scheduler.

    Raises:
        BenchError: for an unknown backend, a scheduler that is missing or cannot be reached, or workers that differ.
    """
    if backend not in BACKENDS:
        raise BenchError(f"unknown backend {backend!r}{nearest(backend, BACKENDS)}")
    if (backend == "dask") != (scheduler is not None):
        raise BenchError("the dask backend needs --scheduler tcp://HOST:PORT, and no other backend takes one")
    if scheduler is None:
        return _processes(jobs)
    from bench.execution.dask import cluster  # needs an extra

    return cluster(scheduler)


@contextmanager
def _processes(jobs: int) -> Iterator[Pool]:
    """Yield worker processes on this machine, which end with the context; -1 takes every core."""
    jobs = cpu_count() if jobs == -1 else jobs
    try:
        yield _Loky(jobs, 2 * jobs, "loky", initializer=supervisor.end_with_parent, initargs=(os.getpid(),))
    finally:
        supervisor.close()  # a single job is made in this process
        if jobs != 1:
            _shut_down()


class _Loky(Pool):
    """Worker processes on this machine."""

    work = staticmethod(supervisor.work)
    deaths = (BrokenProcessPool,)

    def _settle(self) -> None:
        # loky's thread breaks when it is stopped before it has passed all trials on to the workers' queue; that queue
        # has room for a whole window.
        executor = reusable_executor._executor
        while executor is not None and not executor._flags.broken and not executor._work_ids.empty():
            sleep(0.01)

    def _start(self) -> None:
        # Workers inherit the blocked signal, so that Ctrl-C never reaches them: the parent handles it.
        resource_tracker.ensure_running()  # before, as its start unblocks signals
        with _blocked(signal.SIGINT):
            Parallel()([delayed(abs)(0)])


def _shut_down() -> None:
    """End loky's workers, and the threads that fed them."""
    feeders = [each for each in threading.enumerate() if each.name == "QueueFeederThread"]
    with suppress(Exception):
        # Not get_reusable_executor(), which waits for a thread that may wait for a lock that it holds.
        reusable_executor._executor.shutdown(wait=True, kill_workers=True)
    # loky does not wait for them, and one that is cut off while it frees a semaphore leaks it with a warning
    for each in feeders:
        each.join(FEEDING)


@contextmanager
def _blocked(number: int) -> Iterator[None]:
    """Block a signal; processes started meanwhile never receive it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
