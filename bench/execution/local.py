"""Make trials on this machine: a thread for each job, which supervises the processes that make its trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from threading import Lock

from bench.execution.job import Task
from bench.execution.supervisor import KilledError, Supervisor
from bench.trial import Row, Trial

OnBegin = Callable[[int, Trial], None]
Answer = tuple[Trial, Row, str]  # with the record (JSON) of the machine that made it


class Local:
    """A context of a thread for each of ``jobs``, which supervises the processes that make its trials.

    They are kept for the next trials of the same task.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._task: Task | None = None
        self._supervisors: list[Supervisor] = []

    def __enter__(self) -> Local:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def _end(self) -> None:
        for supervisor in self._supervisors:
            supervisor.kill()
        self._supervisors = []

    def answers(
        self, task: Task, machine: str, missing: Callable[[], Iterable[Trial]], on_begin: OnBegin | None = None
    ) -> Iterator[Answer]:
        """Yield each missing trial with its row and its machine's record as they finish, in any order.

        Trials are not handed out one by one: that would cost more than all else that this process does for one.

        Args:
            task: what all trials have in common.
            machine: the record (JSON) of this machine.
            missing: returns the trials that are not finished at the moment they are reached.
            on_begin: called with the number of a job and the trial that it begins, where that is known.
        """
        if self._task is not task or not self._supervisors:
            self._end()
            self._task, self._supervisors = task, [Supervisor(task) for _ in range(self.jobs)]
        trials = iter(missing())
        made: SimpleQueue[tuple[Trial, Row] | BaseException | None] = SimpleQueue()
        turn = Lock()

        def begun(job: int) -> Trial | None:
            with turn:
                trial = next(trials, None)
                if trial is not None and on_begin is not None:
                    on_begin(job, trial)
                return trial

        def supervise(job: int, supervisor: Supervisor) -> None:
            try:
                while (trial := begun(job)) is not None:
                    made.put((trial, supervisor.make(trial)))
            except KilledError:
                pass
            except BaseException as error:
                made.put(error)
            made.put(None)

        with ThreadPoolExecutor(self.jobs) as pool:  # which waits for its threads
            try:
                for job, supervisor in enumerate(self._supervisors):
                    pool.submit(supervise, job, supervisor)
                for _ in range(self.jobs):
                    while (answer := made.get()) is not None:
                        if isinstance(answer, BaseException):
                            raise answer
                        yield *answer, machine
            except BaseException:  # GeneratorExit, too
                self._end()
                raise
