"""Make trials on this machine: a thread for each job, which supervises the processes that make its trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager
from itertools import islice
from queue import SimpleQueue
from threading import Lock

from bench.columns import Row
from bench.execution.job import Task
from bench.execution.supervisor import Supervisor
from bench.trial import Trial

OnBegin = Callable[[int, Trial], None]
Answer = tuple[Trial, Row, str]  # with the record (JSON) of the machine that made it


class Local(AbstractContextManager["Local"]):
    """A context of ``jobs`` supervisors of processes, which are kept for the next trials of the same task."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
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
        """Yield each missing trial with its row and its machine's record as they finish, in any order.

        Args:
            task: what all trials have in common.
            machine: the record (JSON) of this machine.
            missing: returns the trials that are not finished at the moment they are reached.
            on_begin: called with the number of a job and the trial that it begins, by one thread at a time.
        """
        if self._task is not task or not self._supervisors:
            self._end()
            self._task, self._supervisors = task, [Supervisor(task) for _ in range(self.jobs)]
        idle, turn = SimpleQueue[int](), Lock()
        for job in range(self.jobs):
            idle.put(job)

        def make(trial: Trial) -> Answer:
            job = idle.get()  # there is one for each thread
            try:
                if on_begin is not None:
                    with turn:
                        on_begin(job, trial)
                return trial, self._supervisors[job].make(trial), machine
            finally:
                idle.put(job)

        with ThreadPoolExecutor(self.jobs) as pool:  # which waits for its threads
            try:
                trials = iter(missing())
                begun = {pool.submit(make, trial) for trial in islice(trials, 2 * self.jobs)}  # so that none waits
                while begun:
                    done, begun = wait(begun, return_when=FIRST_COMPLETED)
                    begun |= {pool.submit(make, trial) for trial in islice(trials, len(done))}
                    for future in done:
                        yield future.result()
            except BaseException:  # GeneratorExit, too
                pool.shutdown(wait=False, cancel_futures=True)
                self._end()
                raise
