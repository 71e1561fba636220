"""Have trials made in processes that can be lost, and turn hangs, crashes, excess and false answers into rows."""

from __future__ import annotations

import json
import signal
import threading
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from typing import Any

from bench.execution import answers, trial_process
from bench.execution.answers import RefusedError
from bench.execution.job import LOADING, Job, Task, root
from bench.helpers.errors import PROBLEM_FAILED, BenchError
from bench.helpers.parsing import JsonObject
from bench.helpers.text import printable
from bench.plugins.inputs import Present
from bench.plugins.packing import Objects
from bench.sandbox.forks import ForkServer
from bench.sandbox.process import (
    FAILURES,
    DiedError,
    LostError,
    MemoryExceededError,
    PrintedTooMuchError,
    RemoteError,
    TimeExceededError,
)
from bench.sandbox.server import STILL_ASKING, UNANSWERABLE
from bench.storage import provenance
from bench.study import Study
from bench.study.descriptions import Description, Descriptions, describe, read
from bench.trial.columns import Row
from bench.trial.trial import Trial

DESCRIBING = 60.0  # seconds for what the optimizers of one package print of themselves
CHECKS = 4  # attempts at it, where its process is killed from outside
ATTEMPTS = 2  # at a trial whose process, or the one it was forked from, is killed from outside
_SIGNALS = [getattr(signal, name) for name in ("SIGKILL", "SIGTERM") if hasattr(signal, name)]
KILLED = {code for number in _SIGNALS for code in (-number, 128 + number)}
"""Exit codes after a kill from outside, by the system when memory runs out or by a person; a sandbox adds 128."""


@dataclass(frozen=True)
class Loaded:
    """A study whose plug-ins can be loaded: its dimensions, what they load, the machine (JSON) and its optimizers."""

    dimensions: dict[str, int]
    present: Present
    machine: str
    descriptions: Descriptions


class KilledError(RuntimeError):
    """The supervisor was ended by another thread."""


class WorkerDiedError(RuntimeError):
    """Workers were killed several times in a row, or their scheduler was lost; every finished trial is kept."""


def check(task: Task) -> Loaded:
    """Load all plug-ins of a study once; see :meth:`Supervisor.load`."""
    with closing(Supervisor(task)) as supervisor:
        return supervisor.load()


def _loaded_in_forks(problems: ForkServer, study: Study) -> Loaded:
    """Load the problems, then side by side the optimizers of each package in a fork of their process.

    Raises:
        BenchError: for the first plug-in that fails.
        Exception: for answers of another form, which plug-in code wrote in place of the harness.
    """

    def sound(answer: Any) -> JsonObject:
        if "error" in answer:
            raise BenchError(printable(str(answer["error"]), 4000))
        return dict(answer)

    answer = sound(problems.call(trial_process.check_problems, seconds=LOADING))
    modules = {entry.label: dict(answer["modules"]) for entry in study.problems}
    dimensions = {entry.label: int(answer["dimensions"][entry.label]) for entry in study.problems}
    machine = dict(answer["machine"])
    packages = [(labels, problems.process()) for labels in study.packages().values()]
    for labels, process in packages:
        process.start(trial_process.check_optimizers, labels, dimensions)
    for labels, process in packages:
        answer = sound(process.finish(seconds=LOADING))
        machine = provenance.united(machine, dict(answer["machine"]))
        modules |= {label: dict(answer["modules"]) for label in labels}

    described = {entry.label: Description() for entry in study.optimizers}
    for labels, process in packages:
        with suppress(LostError, *FAILURES), process:  # a plug-in may print anything of itself, and end its process
            described |= read(process.call(describe, study, labels, seconds=DESCRIBING), labels)
    return Loaded(dimensions, Present(modules), json.dumps(machine), described)


def is_killed(error: Exception) -> bool:
    """Return whether a process, or one that it was forked from, was ended from outside: it may be no fault of it."""
    return isinstance(error, LostError) or (isinstance(error, DiedError) and error.code in KILLED)


def failed(reason: str) -> Row:
    """Return the row of a trial that failed."""
    return {"status": "failed", "error": printable(reason, 4000)}


class Supervisor:
    """Has trials made one at a time, in processes that are replaced where they are lost.

    One thread uses it; any may end it by :meth:`kill`. ``start`` starts the processes of a task.
    """

    def __init__(self, task: Task, start: Callable[..., Job] = Job) -> None:
        self._task, self._start = task, start
        self._lock, self._killed = threading.Lock(), False
        self._job: Job | None = None
        self._first: ForkServer | None = None  # the root of what has loaded the study, until a job has both
        self._checked: ForkServer | None = None

    def close(self) -> None:
        """End all processes; others are started for the next trial."""
        with self._lock:
            ended = self._job, self._first
            self._job = self._first = self._checked = None
        for each in ended:
            if each is not None:
                each.kill()

    def kill(self) -> None:
        """End all processes from another thread; a trial under way then ends with KilledError."""
        with self._lock:
            self._killed = True
            for each in (self._job, self._first):
                if each is not None:
                    each.kill()

    def load(self) -> Loaded:
        """Load all plug-ins of the study, the optimizers of each package in their own copy.

        So no module's code can change what is found of another one. The process that has loaded the problems is kept
        for the job that makes the trials.

        Raises:
            BenchError: for the first name, parameter, recording or budget that cannot work, or for plug-ins that hang
                or crash while they are loaded.
            KilledError: after :meth:`kill`.
        """
        doing, study = "loading the study's problems and optimizers", self._task.study
        for left in reversed(range(CHECKS)):
            try:
                with self._lock:
                    if self._killed:
                        raise KilledError
                    self._first = first = root(self._task)
                self._checked = first.branch()  # so that the parent of what runs plug-ins is not this process
                return _loaded_in_forks(self._checked, study)
            except BenchError:
                raise
            except TimeExceededError as error:
                raise BenchError(
                    f"{doing} takes more than {error}; try each with 'bench solve' to find which hangs"
                ) from error
            except (DiedError, RemoteError, LostError) as error:
                self.close()
                if not (left and is_killed(error)):
                    raise BenchError(f"{doing} failed: {error}") from error
            except (AttributeError, KeyError, TypeError, ValueError) as error:
                raise BenchError(f"{doing} failed: a plug-in answered in place of the harness") from error
        raise AssertionError("the last loss is raised")

    def make(self, trial: Trial, held: Objects | None = None) -> Row:
        """Have a trial made; return its row, whether it finishes, fails or times out.

        A trial is begun once more where a process that it needs is killed from outside, as that may not be its fault.

        Args:
            trial: the trial.
            held: what takes the place of its plug-ins in the process of this trial alone.

        Raises:
            KilledError: after :meth:`kill`.
        """
        for _ in range(ATTEMPTS):
            try:
                job = self._started()
            except BenchError as error:  # there is no sandbox here
                return failed(str(error))
            try:
                return self._made(trial, job, held or {})
            except LostError:
                lost = "its process or one that it was forked from was ended or stopped"
            except (*FAILURES, RefusedError, ValueError) as error:
                if not (is_killed(error) or self._killed):
                    return row_of(error, job.doing, self._cut)
                lost = f"its process ended with {error}"
            self.close()  # what killed one process may have killed or stopped others
            if self._killed:
                raise KilledError
        return failed(f"{lost} twice; the machine may be short of memory")

    def _cut(self, reason: str) -> str:
        """Return the message of a failure; without traceback and output, by which a sandbox would let out files."""
        return reason.partition("\n")[0] if self._task.untrusted else reason

    def _started(self) -> Job:
        with self._lock:
            if self._killed:
                raise KilledError
            if self._job is None:
                self._job = self._start(self._task, self._first, self._checked)
                self._first = self._checked = None
            return self._job

    def _made(self, trial: Trial, job: Job, held: Objects) -> Row:
        """Have a trial made; return its row once its answer is checked.

        The row's ``beside`` is what no column holds: ``after`` is that of
        :meth:`bench.execution.again.Repetition.consider`, ``inputs`` are what it was made from, as JSON, ``unasked`` is
        that of :class:`bench.trial.trial.Usage`, and ``journal`` counts what became of the evaluations in its journal.
        """
        job.doing = "while its plug-ins were loaded"
        box = job.box(trial.problem)
        if isinstance(box, str):
            return failed(box)
        server = job.prepare(trial)
        job.doing = ""
        after = server.before(trial.problem)
        answer = job.make(trial, server, held)
        if reason := answers.error(answer):
            return failed(self._cut(reason))
        row = answers.row(answer, box, self._task.study.budget.evaluations(len(box.lower)))
        counted = {key: number for key in ("replayed", "dropped") if type(number := answer.get(key)) is int}
        beside = {"after": after, "inputs": answer.get("inputs"), "unasked": answer.get("unasked") is True}
        return row | {"beside": beside | {"journal": counted}}


def row_of(error: Exception, doing: str = "", cut: Callable[[str], str] = str) -> Row:
    """Return the row of a trial that ended with one of the errors of its process, or with a false answer.

    Args:
        error: one of :data:`bench.sandbox.process.FAILURES`, a RefusedError, or a ValueError of what is no column.
        doing: what was done then, beside the trial itself.
        cut: shortens what a process said at its end.
    """
    match error:
        case DiedError():
            return failed(cut(_why_it_ended(error)))
        case TimeExceededError():
            where = f"{doing}, after {error}" if doing else f"after {error}, the limit of a trial"
            return {"status": "timeout", "error": f"stopped {where} (--timeout)"}
        case MemoryExceededError():
            return failed(f"{error} (--memory)")
        case PrintedTooMuchError():
            return failed(f"{error}; have it print less, as by verbose=False")
        case RefusedError():
            return failed(f"its answer is refused: {error}")
        case RemoteError():
            return failed(f"{error} {doing}".strip())
        case ValueError():  # metrics or variables that are no columns
            return failed(f"{PROBLEM_FAILED}{error}")
    return failed(str(error))


def make_one(task: Task, trial: Trial) -> Row:
    """Have a single trial of a checked task made, in processes that end with it; return its row."""
    with closing(Supervisor(task)) as supervisor:
        return supervisor.make(trial)


def _why_it_ended(error: DiedError) -> str:
    """Return why a trial's process ended."""
    if error.code == STILL_ASKING:
        return "went on asking for values after its budget was spent; let BudgetExhausted pass"
    if error.code == UNANSWERABLE:
        return "closed files that are not its own, through which its process answers"
    output = f"\n{error.end_of_output}" if error.end_of_output else ""
    return f"its process ended with {error}{output}"
