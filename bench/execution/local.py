"""Make trials on this machine: a thread for each job, which supervises the processes that make its trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from queue import SimpleQueue
from threading import Lock

from bench.execution.pool import Answer, OnBegin, ignore
from bench.execution.supervisor import KilledError, Supervisor, Task
from bench.sandbox.pool import side_by_side
from bench.trial import Row, Trial


class Local:
    """A thread for each job, which supervises the processes that make its trials."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs

    def answers(
        self, task: Task, machine: str, missing: Callable[[], Iterable[Trial]], on_begin: OnBegin = ignore
    ) -> Iterator[Answer]:
        """Yield answers; see :meth:`Pool.answers`.

        Trials are not handed out one by one: that would cost more than all else that this process does for one.
        """
        supervisors = [Supervisor(task) for _ in range(self.jobs)]
        trials = iter(missing())
        made: SimpleQueue[tuple[Trial, Row] | BaseException | None] = SimpleQueue()
        turn = Lock()

        def supervise(job: int, supervisor: Supervisor) -> None:
            try:
                for trial in _noted(trials, partial(on_begin, job), turn):
                    made.put((trial, supervisor.make(trial)))
            except KilledError:
                pass
            except BaseException as error:
                made.put(error)
            made.put(None)

        def end() -> None:
            for each in supervisors:
                each.kill()

        with side_by_side([partial(supervise, *each) for each in enumerate(supervisors)], end):
            for _ in supervisors:
                while (answer := made.get()) is not None:
                    if isinstance(answer, BaseException):
                        raise answer
                    yield *answer, machine


def _noted(trials: Iterator[Trial], on_begin: Callable[[Trial], None], turn: Lock) -> Iterator[Trial]:
    """Yield trials that other jobs take from as well, in turn; note each when it begins."""
    while True:
        with turn:
            trial = next(trials, None)
            if trial is None:
                return
            on_begin(trial)
        yield trial
