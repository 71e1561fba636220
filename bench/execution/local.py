"""Make trials on this machine: supervisors side by side, each of which owns the processes that make its trials."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import replace
from threading import Lock

from joblib import effective_n_jobs

from bench.execution.job import KEPT, Task
from bench.execution.supervisor import Loaded, Supervisor
from bench.helpers.errors import BenchError
from bench.helpers.parallel import side_by_side
from bench.storage import provenance
from bench.trial.columns import Row
from bench.trial.trial import Trial

OnBegin = Callable[[int, Trial], None]
Missing = Callable[[], Iterable[Trial]]
Answer = tuple[Trial, Row, str]  # with the record (JSON) of the machine that made it

try:
    import resource
except ImportError:  # on Windows, which counts no sockets
    resource = None  # type: ignore[assignment]

SHARE = 0.9  # of the machine's memory, for the jobs together
FILES = 40 + 4 * KEPT  # open files of a job: four of each warmed-up optimizer, and those of a process that starts
RESERVE = 64  # for all else: the store, figures, modules that are imported


class Local(AbstractContextManager["Local"]):
    """A context of ``n_jobs`` supervisors of processes, which are kept for further trials of its task.

    ``supervise`` makes one of a task. The study is loaded by the first of them, which then makes trials.

    Attributes:
        jobs: their number.
        share: the bytes of the machine's memory for a trial of each.

    Raises:
        BenchError: where the system allows too few open files.
    """

    _task: Task  # what was loaded, and the record of the machine that loaded it
    _machine: str

    def __init__(self, n_jobs: int, supervise: Callable[[Task], Supervisor] = Supervisor) -> None:
        self._supervise = supervise
        self.jobs = effective_n_jobs(n_jobs)
        self.share = int(SHARE * provenance.memory() / self.jobs)
        require_files(self.jobs)
        self._supervisors: list[Supervisor] = []

    def __exit__(self, *_: object) -> None:
        self._end()

    def _end(self) -> None:
        for supervisor in self._supervisors:
            supervisor.kill()
        self._supervisors = []

    def load(self, task: Task, *, shared: bool = False) -> Loaded:
        """Load all plug-ins of a study; see :meth:`bench.execution.supervisor.Supervisor.load`.

        Args:
            task: what all trials have in common.
            shared: whether a trial is limited to its share of the machine's memory, if not to less.
        """
        if shared:
            task = replace(task, memory=min(task.memory or self.share, self.share))
        self._task = task
        loaded = self._started()[0].load()
        self._machine = loaded.machine
        return loaded

    def _started(self) -> list[Supervisor]:
        self._supervisors = self._supervisors or [self._supervise(self._task) for _ in range(self.jobs)]
        return self._supervisors

    def answers(self, on_begin: OnBegin | None, missing: Missing) -> Iterator[Answer]:
        """Return each missing trial of the study that was loaded, with its row and its machine's record, in any order.

        Args:
            on_begin: called with the number of a job and the trial that it begins, by one thread at a time.
            missing: returns the trials that are not finished at the moment they are reached.
        """
        idle, turn = [*enumerate(self._started())][::-1], Lock()  # the first one has loaded the study

        def make(trial: Trial) -> Answer:
            job, supervisor = idle.pop()  # there is one for each thread
            try:
                if on_begin is not None:
                    with turn:
                        on_begin(job, trial)
                return trial, supervisor.make(trial), self._machine
            finally:
                idle.append((job, supervisor))

        return side_by_side(make, missing(), self.jobs, in_order=False, end=self._end)


def require_files(n_jobs: int) -> None:
    """Raise the soft limit of open files to what the jobs need.

    Raises:
        BenchError: where the system's hard limit is lower.
    """
    if resource is None:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = RESERVE + n_jobs * FILES
    if 0 <= soft < wanted:  # -1 is no limit
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
        except (OSError, ValueError) as error:
            fewer = max(1, (hard - RESERVE) // FILES)
            raise BenchError(
                f"{n_jobs} jobs need {wanted:,} open files, and this system allows a process {hard:,}; run {fewer} at "
                f"a time (--jobs {fewer}), or allow more (ulimit -Hn {wanted})"
            ) from error
