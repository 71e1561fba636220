"""Have trials made in processes that can be lost, and turn hangs, crashes, excess and false answers into rows."""

from __future__ import annotations

import json
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from time import monotonic
from typing import Any, TypeVar

from bench.errors import BenchError
from bench.execution import answers, trial_process
from bench.execution.answers import Box, RefusedError
from bench.execution.job import LOADING, PRINTED, Job, root
from bench.helpers.text import printable
from bench.plugins import from_file
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
from bench.sandbox.server import FORKS, STILL_ASKING, UNANSWERABLE
from bench.storage import provenance
from bench.study import Fingerprints, Study
from bench.trial import Result, Row, Trial, as_row

CHECKS = 4  # attempts at it, where its process is killed from outside
TOGETHER = 0.1  # seconds of trials whose best points are evaluated again together: a call costs more than a point
ATTEMPTS = 2  # at a trial whose process, or the one it was forked from, is killed from outside
_SIGNALS = [getattr(signal, name) for name in ("SIGKILL", "SIGTERM") if hasattr(signal, name)]
KILLED = {code for number in _SIGNALS for code in (-number, 128 + number)}
"""Exit codes after a kill from outside, by the system when memory runs out or by a person; a sandbox adds 128."""


@dataclass(frozen=True)
class Task:
    """What every trial of a run has in common."""

    study: Study  # as frozen in its folder; processes load its plug-ins by name
    timeout: float | None = None  # wall seconds that a trial may take
    memory: int | None = None  # bytes that a trial's process may hold
    hash_seed: int = 0  # PYTHONHASHSEED of the processes, which orders sets of strings
    strict: bool = False  # whether problem, budget and trace are kept in another process than the optimizer
    sandbox: str | None = None  # in which all processes run
    package: str = field(default_factory=provenance.package)  # of the parent; a worker with another one is refused


@dataclass(frozen=True)
class Checked:
    """A study whose plug-ins can be loaded: its fingerprints, and the machine's record as JSON."""

    fingerprints: Fingerprints
    machine: str


@dataclass(frozen=True)
class _Claim:
    """What a trial's process claims as its result: possible, but not confirmed."""

    trial: Trial
    result: Result  # without metrics
    box: Box
    seconds: float  # that it took

    @property
    def point(self) -> tuple[str, list[float]]:
        """The problem and the best point."""
        return self.trial.problem, self.result.x.tolist()

    def row(self, metrics: dict[str, float]) -> Row:
        """Return the row of the result; raises ValueError for metrics or variables that are no columns."""
        return as_row(replace(self.result, metrics=metrics), self.box.variables)


_Found = TypeVar("_Found")


class KilledError(RuntimeError):
    """The supervisor was ended by another thread."""


def check(task: Task) -> Checked:
    """Load all plug-ins of a study (:meth:`bench.study.Study.check`), the optimizers of each package in their own copy.

    So no package's code can change the fingerprints of the data, or of another package.

    Raises:
        BenchError: for the first name, parameter, recording or budget that cannot work, or for plug-ins that hang or
            crash while they are loaded.
    """
    doing = "loading the study's problems and optimizers"
    for left in reversed(range(CHECKS)):
        try:
            with root(task.study, task.sandbox, hash_seed=task.hash_seed) as server:
                return _checked(server, task.study)
        except BenchError:
            raise
        except TimeExceededError as error:
            raise BenchError(
                f"{doing} takes more than {error}; try each with 'bench solve' to find which hangs"
            ) from error
        except (DiedError, RemoteError, LostError) as error:
            killed = isinstance(error, LostError) or (isinstance(error, DiedError) and error.code in KILLED)
            if not (killed and left):
                raise BenchError(f"{doing} failed: {error}") from error
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise BenchError(f"{doing} failed: a plug-in answered in place of the harness") from error
    raise AssertionError("the last loss is raised")


def _checked(first: ForkServer, study: Study) -> Checked:
    """Return what forks of a process find; raises what they raise, or whatever a strange answer leads to."""

    def ask(server: ForkServer, labels: Iterable[str], *call: Any) -> tuple[dict[str, str], dict[str, Any]]:
        found = server.call(*call, seconds=LOADING)
        if "error" in found:
            raise BenchError(printable(str(found["error"]), 4000))
        return {label: str(found["hashes"][label]) for label in labels if label in found["hashes"]}, found

    problems = first.branch()  # so that the parent of the process in which plug-ins run is not this one
    problems.call(trial_process.begin, study, seconds=LOADING)
    data, found = ask(problems, [each.label for each in study.problems], trial_process.check_problems)
    code: dict[str, str] = {}
    machine, least = dict(found["machine"]), int(found["least"])
    for labels in study.packages().values():
        hashes, found = ask(problems.branch(), labels, trial_process.check_optimizers, labels, least)
        code, machine = code | hashes, provenance.united(machine, dict(found["machine"]))
    named = {each.label: from_file.fingerprint(each.name) for each in study.with_controls if from_file.split(each.name)}
    return Checked(Fingerprints(data, code | named), json.dumps(machine))


def failed(reason: str) -> Row:
    """Return the row of a trial that failed."""
    return {"status": "failed", "error": printable(reason, 4000)}


class Supervisor:
    """Has trials made one at a time, in processes that are replaced where they are lost.

    One thread uses it; any may end it by :meth:`kill`.
    """

    def __init__(self, task: Task) -> None:
        if task.strict and not FORKS:
            raise BenchError("strict trials need processes that fork, which this system does not offer; use Linux")
        self._task = task
        self._lock, self._killed = threading.Lock(), False
        self._job: Job | None = None
        self._doing = ""  # beside the trial itself, for messages

    def close(self) -> None:
        """End all processes; others are started for the next trial."""
        with self._lock:
            job, self._job = self._job, None
        if job is not None:
            job.kill()

    def kill(self) -> None:
        """End all processes from another thread; a trial under way then ends with KilledError."""
        with self._lock:
            self._killed = True
            if self._job is not None:
                self._job.kill()

    def make(self, trials: Iterable[Trial]) -> Iterator[tuple[Trial, Row]]:
        """Yield each trial with its row, whether it finishes, fails or times out.

        A trial whose process is killed from outside is begun once more, as that may not be the trial's fault. The best
        points of short trials are evaluated again together.

        Raises:
            KilledError: after :meth:`kill`.
        """
        claims: list[_Claim] = []
        evaluated = monotonic()
        for trial in trials:
            found = self._insist(partial(self._claim, trial))
            if isinstance(found, _Claim):
                claims.append(found)
            else:
                yield trial, found
            if monotonic() - evaluated > TOGETHER:
                yield from self._confirm(claims)
                claims, evaluated = [], monotonic()
        yield from self._confirm(claims)

    def _started(self) -> Job:
        with self._lock:
            if self._killed:
                raise KilledError
            if self._job is None:
                task = self._task
                self._job = Job(
                    task.study, task.hash_seed, task.timeout, task.memory, strictly=task.strict, sandbox=task.sandbox
                )
            return self._job

    def _insist(self, work: Callable[[Job], _Found]) -> _Found | Row:
        """Return what ``work`` finds with the processes, or the row of its failure; repeat it where one is killed."""
        for _ in range(ATTEMPTS):
            self._doing, lost = "", ""
            found: _Found | Row = {}
            try:
                found = work(self._started())
            except LostError:
                lost = "its process or one that it was forked from was ended or stopped"
            except DiedError as error:
                found = failed(_why_it_ended(error))
                lost = f"its process ended with {error}" if error.code in KILLED else ""
            except TimeExceededError as error:
                where = f"{self._doing}, after {error}" if self._doing else f"after {error}, the limit of a trial"
                found = {"status": "timeout", "error": f"stopped {where} (--timeout)"}
            except MemoryExceededError as error:
                found = failed(f"{error} (--memory)")
            except PrintedTooMuchError:
                found = failed(f"printed more than {PRINTED / 1e6:g} MB; have it print less, as by verbose=False")
            except RefusedError as error:
                found = failed(f"its answer is refused: {error}")
            except (RemoteError, ValueError) as error:  # ValueError: metrics or variables that are no columns
                found = failed(f"{error} {self._doing}".strip())
            if not (lost or self._killed):
                return found
            self.close()  # what killed one process may have killed or stopped others
            if self._killed:
                raise KilledError
        return failed(f"{lost} twice; the machine may be short of memory")

    def _claim(self, trial: Trial, job: Job) -> Row | _Claim:
        """Have a trial made; return what its optimizer's process claims, or the row where another one kept account."""
        self._doing = "while its plug-ins were loaded"
        box = job.box(trial.problem)
        if isinstance(box, str):
            return failed(box)
        server = job.prepare(trial)
        self._doing = ""
        make = job.make_strictly if self._task.strict else job.make
        answer, seconds = make(trial, server)
        if reason := answers.error(answer):
            return failed(reason)
        budget = self._task.study.evaluations(len(box.lower))
        claim = _Claim(trial, answers.result(answer, box, budget, trial.seed, seconds), box, seconds)
        return claim.row(answers.metrics(answer)) if self._task.strict else claim

    def _confirm(self, claims: Sequence[_Claim]) -> Iterator[tuple[Trial, Row]]:
        """Yield the trials of claims with their rows, once their best points have been evaluated again.

        Where anything goes wrong with one of many, each is evaluated alone, so that it alone fails.
        """
        found: list[Any] = [None] * len(claims)
        if claims:
            with suppress(*FAILURES, LostError):
                found = self._started().evaluate(
                    [claim.point for claim in claims], sum(each.seconds for each in claims)
                )
        for claim, again in zip(claims, found, strict=True):
            try:
                row = claim.row(answers.confirm(claim.result, claim.box, again))
            except (RefusedError, ValueError):
                row = self._insist(partial(self._reconsider, claim))
            yield claim.trial, row

    def _reconsider(self, claim: _Claim, job: Job) -> Row:
        """Return the row of a claim whose best point is evaluated again by a new evaluator."""
        self._doing = "while its best point was evaluated again"
        (again,) = job.evaluate([claim.point], claim.seconds, anew=True)
        return claim.row(answers.confirm(claim.result, claim.box, again))


def _why_it_ended(error: DiedError) -> str:
    """Return why a trial's process ended."""
    if error.code == STILL_ASKING:
        return "went on asking for values after its budget was spent; let BudgetExhausted pass"
    if error.code == UNANSWERABLE:
        return "closed files that are not its own, through which its process answers"
    output = f"\n{error.end_of_output}" if error.end_of_output else ""
    return f"its process ended with {error}{output}"
