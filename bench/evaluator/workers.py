"""Make trials of one candidate after the other in processes that are forked from warm ones, which no candidate enters.

problems         all problems loaded
  └ server       serves the problem of one trial after the other, until one fails
  └ baselines    makes trials of trusted optimizers
optimizers       without any problem; libraries loaded, a search warmed up
  └ candidate    loads a candidate and makes one trial of it
"""

from __future__ import annotations

import re
from collections.abc import Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from threading import Lock, local
from typing import Any

from joblib import effective_n_jobs

from bench.execution import answers, apart, trial_process
from bench.execution.answers import Box, RefusedError
from bench.execution.job import LOADING, PRINTED, Task, make_apart, sandbox_of
from bench.execution.supervisor import ATTEMPTS, failed, is_killed, row_of
from bench.helpers.errors import BenchError
from bench.plugins.packing import Objects
from bench.sandbox.bubblewrap import Sandbox
from bench.sandbox.forks import ForkServer
from bench.sandbox.process import FAILURES, LostError, Process
from bench.trial.columns import Row
from bench.trial.trial import Trial

LIBRARIES = ("scipy.linalg", "scipy.optimize", "scipy.spatial.distance", "scipy.special", "scipy.stats")
"""What candidates often import; each would take a part of their time."""

WARMING = "random-search"
"""The label of an optimizer of every task, which stands for candidates in a short search."""


@dataclass
class Candidate:
    """A candidate on its way through its trials; the others are left out once one has failed."""

    held: Objects  # what its name stands for; empty of baselines, which are installed
    text: str = ""  # its source, if it has one
    error: str = ""

    @property
    def reason(self) -> str:
        """The error, with the text of the line that is at fault."""
        error = self.error.removesuffix(" (--timeout)").removesuffix(" (--memory)")
        lines, found = self.text.splitlines(), re.match(r"line (\d{1,7}): ", error)
        at_fault = found and lines[int(found[1]) - 1 : int(found[1])]
        return f"{error} ({at_fault[0].strip()[:100]})" if at_fault else error


class Workers:
    """Threads that have trials made, each by processes of its own.

    Threads, as a sandbox ends with the thread that has started it: those of joblib end with every call.
    """

    def __init__(self, task: Task, n_jobs: int) -> None:
        self._task, self._local, self._lock = task, local(), Lock()
        self._sandboxes = sandbox_of(task), sandbox_of(task, without_problems=True)
        self._started: list[_Worker] = []
        self._threads = ThreadPoolExecutor(effective_n_jobs(n_jobs), "evaluator")

    def rows(self, trials: Iterable[tuple[Candidate, Trial]]) -> Generator[Row]:
        """Yield the rows of trials in their order; of a candidate that has failed, none is made any more."""
        return self._threads.map(self._row, trials)  # type: ignore[return-value]

    def close(self) -> None:
        """End all processes and threads."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            for worker in self._started:
                worker.closed = True
                worker.kill()

    def _row(self, task: tuple[Candidate, Trial]) -> Row:
        candidate, trial = task
        if candidate.error:
            return {"status": "failed", "error": "left out, as the candidate has failed"}
        worker = getattr(self._local, "worker", None)
        if worker is None:
            worker = self._local.worker = _Worker(self._task, self._sandboxes)
            with self._lock:
                self._started.append(worker)
        row = worker.row(candidate, trial)
        if row["status"] != "ok" and not candidate.error:
            candidate.error = str(row["error"])
        return row


class _Worker:
    """The processes of one thread."""

    def __init__(self, task: Task, sandboxes: tuple[Sandbox | None, Sandbox | None]) -> None:
        self._task, self._sandboxes = task, sandboxes
        self._problems = self._optimizers = ForkServer()  # which have no process yet
        self._boxes: dict[str, Box | str] = {}
        self._server: Process | None = None
        self._limits: dict[str, Any] = {"seconds": task.timeout, "memory": task.memory}
        self._ended, self.closed = True, False

    def kill(self) -> None:
        """End all processes; others are started for the next trial."""
        self._ended, self._server, self._boxes = True, None, {}
        for server in (self._problems, self._optimizers):
            server.kill()

    def row(self, candidate: Candidate, trial: Trial) -> Row:
        """Return the row of a trial; it is begun once more where a process is killed from outside."""
        row = failed("the evaluator was closed")
        for attempt in range(ATTEMPTS):
            if self.closed:
                break
            try:
                return self._made(candidate, trial)
            except LostError as error:
                self.kill()
                row = failed(f"its process was lost: {error}")
            except BenchError as error:
                return failed(str(error))
            except (*FAILURES, RefusedError, ValueError) as error:
                self._let_go()
                row = row_of(error, cut=lambda text: text.partition("\n")[0])
                if attempt or not is_killed(error):
                    return row
        return row

    def _made(self, candidate: Candidate, trial: Trial) -> Row:
        box = self._box(trial.problem)
        if self._server is None or self._server.closed:
            self._server = self._problems.process()
        if candidate.held:
            process = self._optimizers.process()
            try:
                process.call(trial_process.hold, candidate.held, **self._limits)
                answer = make_apart(trial, box, self._server, process, self._limits)
            finally:
                with suppress(LostError):
                    process.close()
        else:
            answer = self._server.call(trial_process.make, trial, seconds=LOADING, printed=PRINTED)
            confirmed = self._server.call(trial_process.confirm, trial.problem, seconds=LOADING)
            answer = answer | confirmed
        if reason := answers.error(answer):
            return failed(reason.partition("\n")[0])
        return answers.row(answer, box, self._task.study.evaluations(len(box.lower)))

    def _box(self, problem: str) -> Box:
        """Return the box of a problem, once all are loaded, and the processes started from which others are forked."""
        if self._ended:
            self._start()
        box = self._boxes[problem]
        if isinstance(box, str):
            raise BenchError(box)
        return box

    def _start(self) -> None:
        problems, optimizers = (ForkServer(sandbox=each) for each in self._sandboxes)
        self._problems, self._optimizers, study = problems, optimizers, self._task.study
        problems.call(*self._task.beginning(), seconds=LOADING)
        optimizers.call(*self._task.beginning(without_problems=True), seconds=LOADING)
        for entry in study.problems:
            described = problems.call(trial_process.load_problem, entry.label, seconds=LOADING)
            self._boxes[entry.label] = described.partition("\n")[0] if isinstance(described, str) else Box.of(described)
        for entry in study.optimizers[1:]:
            problems.call(trial_process.load_optimizer, entry.label, seconds=LOADING)
        optimizers.call(trial_process.import_modules, LIBRARIES, seconds=LOADING)
        optimizers.call(apart.hide_problems, seconds=LOADING)
        for box in self._boxes.values():
            optimizers.call(trial_process.warm_up, WARMING, box, seconds=LOADING)
        self._ended = False

    def _let_go(self) -> None:
        """End the process that serves problems, whose last answer is not read."""
        with suppress(LostError):
            if self._server is not None:
                self._server.close()
        self._server = None
