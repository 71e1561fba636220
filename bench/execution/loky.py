"""Trials made on this machine, by loky's worker processes."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from time import sleep

from joblib import Parallel, cpu_count, delayed
from joblib.externals.loky import reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from bench.execution import supervisor
from bench.execution.pool import Pool

FEEDING = 5.0  # seconds that a thread which feeds workers may take to see that there are none any more


@contextmanager
def processes(jobs: int) -> Iterator[Pool]:
    """Yield worker processes of this machine, which end with the context; -1 takes every core."""
    jobs = cpu_count() if jobs == -1 else jobs
    try:
        yield Loky(jobs, 2 * jobs, "loky", initializer=supervisor.end_with_parent, initargs=(os.getpid(),))
    finally:
        supervisor.close()  # a single job is made in this process
        if jobs != 1:
            _shut_down()


class Loky(Pool):
    """Processes on this machine."""

    work = staticmethod(supervisor.work)
    deaths = (BrokenProcessPool,)

    def _settle(self) -> None:
        # loky's thread breaks when it is stopped with trials in hand that it has not passed on to the workers' queue;
        # that queue has room for all of a window.
        executor = reusable_executor._executor
        while executor is not None and not executor._flags.broken and not executor._work_ids.empty():
            sleep(0.01)

    def _start(self) -> None:
        # Workers that inherit a blocked Ctrl-C are deaf to it from the first: it is the parent's to answer.
        resource_tracker.ensure_running()  # it lets through what is held, when it starts
        with _blocked(signal.SIGINT):
            Parallel()([delayed(abs)(0)])


def _shut_down() -> None:
    """End loky's workers, and the threads that fed them."""
    feeders = [each for each in threading.enumerate() if each.name == "QueueFeederThread"]
    with suppress(Exception):
        # Not get_reusable_executor(), which waits for a thread that may wait for a lock that it holds.
        reusable_executor._executor.shutdown(wait=True, kill_workers=True)
    for each in feeders:  # loky leaves them to themselves: one that is cut off as it frees a semaphore leaks it, loudly
        each.join(FEEDING)


@contextmanager
def _blocked(number: int) -> Iterator[None]:
    """Hold a signal back; processes that are started meanwhile never see it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
