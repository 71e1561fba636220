"""Make trials on this machine: supervisors side by side, each of which owns the processes that make its trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from threading import Lock

from joblib import effective_n_jobs

from bench.columns import Row
from bench.execution.job import Task
from bench.execution.supervisor import Supervisor
from bench.helpers.parallel import side_by_side
from bench.trial import Trial

OnBegin = Callable[[int, Trial], None]
Answer = tuple[Trial, Row, str]  # with the record (JSON) of the machine that made it


class Local(AbstractContextManager["Local"]):
    """A context of ``n_jobs`` supervisors of processes, which are kept for the next trials of the same task."""

    def __init__(self, n_jobs: int) -> None:
        self.jobs = effective_n_jobs(n_jobs)
        self._task: Task | None = None
        self._supervisors: list[Supervisor] = []

    def __exit__(self, *_: object) -> None:
        self._end()

    def _end(self) -> None:
        for supervisor in self._supervisors:
            supervisor.kill()
        self._supervisors = []

    def answers(
        self, task: Task, machine: str, missing: Callable[[], Iterable[Trial]], on_begin: OnBegin | None = None
    ) -> Iterator[Answer]:
        """Return each missing trial with its row and its machine's record as they finish, in any order.

        Args:
            task: what all trials have in common.
            machine: the record (JSON) of this machine.
            missing: returns the trials that are not finished at the moment they are reached.
            on_begin: called with the number of a job and the trial that it begins, by one thread at a time.
        """
        if self._task is not task or not self._supervisors:
            self._end()
            self._task, self._supervisors = task, [Supervisor(task) for _ in range(self.jobs)]
        idle, turn = [*enumerate(self._supervisors)], Lock()

        def make(trial: Trial) -> Answer:
            job, supervisor = idle.pop()  # there is one for each thread
            try:
                if on_begin is not None:
                    with turn:
                        on_begin(job, trial)
                return trial, supervisor.make(trial), machine
            finally:
                idle.append((job, supervisor))

        return side_by_side(make, missing(), self.jobs, in_order=False, end=self._end)
