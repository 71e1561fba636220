"""Make trials on this machine: a thread for each job, which supervises the processes that make its trials."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from queue import SimpleQueue
from threading import Lock
from typing import Any

from joblib import Parallel, delayed

from bench.execution.interrupts import signals_delayed
from bench.execution.pool import Answer, OnBegin, ignore
from bench.execution.supervisor import KilledError, Supervisor, Task
from bench.trial import Row, Trial


class Local:
    """A thread for each job, which supervises the processes that make its trials."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs

    def answers(
        self, task: Task, machine: str, missing: Callable[[], Iterable[Trial]], on_begin: OnBegin = ignore
    ) -> Iterator[Answer]:
        """Yield answers; see :meth:`Pool.answers`."""
        supervisors = [Supervisor(task) for _ in range(self.jobs)]
        trials = iter(missing())
        try:
            if self.jobs == 1:
                for trial, row in supervisors[0].make(_noted(trials, partial(on_begin, 0), nullcontext())):
                    yield trial, row, machine
                return
            made: SimpleQueue[tuple[Trial, Row] | BaseException | None] = SimpleQueue()
            with _running(supervisors, trials, made, on_begin):
                for _ in supervisors:
                    while (answer := made.get()) is not None:
                        if isinstance(answer, BaseException):
                            raise answer
                        yield *answer, machine
        finally:
            for each in supervisors:
                each.close()


def _noted(
    trials: Iterator[Trial], on_begin: Callable[[Trial], None], turn: AbstractContextManager[Any]
) -> Iterator[Trial]:
    """Yield trials that other jobs take from as well, in turn; note each when it begins."""
    while True:
        with turn:
            trial = next(trials, None)
            if trial is None:
                return
            on_begin(trial)
        yield trial


@contextmanager
def _running(
    supervisors: list[Supervisor],
    trials: Iterator[Trial],
    made: SimpleQueue[tuple[Trial, Row] | BaseException | None],
    on_begin: OnBegin,
) -> Iterator[None]:
    """Have each supervisor take and make trials in a thread of its own; each puts None when there are no more.

    Trials are not handed out by joblib one by one: that would cost more than all else that this process does for one.
    """
    turn = Lock()
    # Of threads that a second interrupt cuts off; joblib may print it whenever it drops them.
    warnings.filterwarnings(
        "ignore", "[0-9]+ tasks (have been successfully executed|which were still being processed)", UserWarning
    )

    def supervise(job: int, supervisor: Supervisor) -> None:
        try:
            for answer in supervisor.make(_noted(trials, partial(on_begin, job), turn)):
                made.put(answer)
        except KilledError:
            pass
        except BaseException as error:
            made.put(error)
        made.put(None)

    with signals_delayed():  # an interrupt while joblib starts threads would leave it in an undefined state
        parallel = Parallel(n_jobs=len(supervisors), backend="threading", return_as="generator_unordered")
        threads = parallel(delayed(supervise)(job, each) for job, each in enumerate(supervisors))
    try:
        yield
    finally:
        for each in supervisors:
            each.kill()
        list(threads)
