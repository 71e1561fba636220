"""Where trials are made: on this machine by loky's processes, or on a cluster by dask's workers."""

from __future__ import annotations

import os
import signal
import threading
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker
from time import sleep
from typing import Any

from joblib import Parallel, cpu_count, delayed, parallel_config
from joblib.externals.loky import reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from bench.errors import BenchError, nearest
from bench.execution import supervisor
from bench.execution.interrupts import undisturbed
from bench.execution.supervisor import Task
from bench.execution.trial_process import Row
from bench.trial import Trial

BACKENDS = ("dask", "loky")
FEEDING = 5.0  # seconds that a thread which feeds workers may take to see that there are none any more
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

    work: Callable[[Task, Trial], Answer] = staticmethod(supervisor.work)
    deaths: tuple[type[Exception], ...] = (BrokenProcessPool,)

    def __init__(self, jobs: int, backend: Any, **options: Any) -> None:
        self.jobs, self.window = jobs, 2 * jobs
        self._backend, self._options = backend, options

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
        with parallel_config(n_jobs=self.jobs, backend=self._backend, **self._options), ExitStack() as ending:
            with undisturbed():  # an interrupt while joblib hands out work would leave it in pieces
                self._start()
                parallel = Parallel(return_as="generator_unordered", batch_size="auto", pre_dispatch=self.window)
                answers = parallel(delayed(self.work)(task, trial) for trial in trials)
                ending.callback(_close, answers)
                self._settle()
            for answer in answers:  # not from it, which would end it, warning, before _close does  # noqa: UP028
                yield answer

    def _start(self) -> None:
        """Start what must be there before the first trial."""

    def _settle(self) -> None:
        """Wait until what was handed out can be taken back."""


class Loky(Pool):
    """Processes on this machine."""

    def _settle(self) -> None:
        # loky's thread breaks when it is stopped with trials in hand that it has not passed on to the workers' queue;
        # that queue has room for all of a window.
        executor = reusable_executor._executor
        while executor is not None and not executor._flags.broken and not executor._work_ids.empty():
            sleep(0.01)

    def _start(self) -> None:
        # Workers that inherit a blocked Ctrl-C are deaf to it from the first: it is the parent's to answer.
        resource_tracker.ensure_running()  # it lets through what is held, when it starts
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
        from bench.execution.dask import cluster

        with cluster(scheduler) as pool:
            yield pool
        return
    try:
        jobs = cpu_count() if jobs == -1 else jobs
        yield Loky(jobs, "loky", initializer=supervisor.attend, initargs=(os.getpid(),))
    finally:
        supervisor.close()  # a single job is made in this process
        if jobs != 1:
            _shut_down()


def _shut_down() -> None:
    """End loky's workers, and the threads that fed them."""
    feeders = [each for each in threading.enumerate() if each.name == "QueueFeederThread"]
    with suppress(Exception):
        # Not get_reusable_executor(), which waits for a thread that may wait for a lock that it holds.
        reusable_executor._executor.shutdown(wait=True, kill_workers=True)
    for each in feeders:  # loky leaves them to themselves: one that is cut off as it frees a semaphore leaks it, loudly
        each.join(FEEDING)


def _close(answers: Generator[Answer]) -> None:
    """End what is under way, without joblib's warning that it was."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        answers.close()


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
