"""The tree of processes of one job: each is forked from the one before it and shares the memory of what is loaded.

    root            trusted code only
    └ problems      of one family, loaded
      ├ judge       evaluates best points again
      └ optimizers  of one package or file, loaded
        └ optimizer warmed up
          └ trial   makes trials of this optimizer until they have taken WORTH times as long as its fork

So no optimizer runs in a process in which another one has run or has been imported, unless one package holds both.
"""

from __future__ import annotations

import socket
from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from itertools import count
from time import monotonic
from typing import Any

from bench.execution import strict, trial_process
from bench.execution.answers import Box, boxes
from bench.plugins import loading
from bench.sandbox import bubblewrap
from bench.sandbox.process import (
    DiedError,
    LostError,
    MemoryExceededError,
    PrintedTooMuchError,
    Process,
    RemoteError,
    TimeExceededError,
)
from bench.study import Study
from bench.trial import Trial

LOADING = 60.0  # seconds, beside the limit of a trial, for loading plug-ins and for a warm-up
SILENCE = 3.0  # least seconds of a warm-up in which nothing is imported or compiled
PRINTED = 1_000_000  # bytes that a trial may print: they are discarded, but writing them takes time from other trials
KEPT = 64  # warmed-up optimizers; more are warmed up again when their turn comes
WORTH = 50.0  # times the seconds of its fork: a process is replaced once its trials have taken longer

_cores = count()

Key = tuple[str, str]  # what holds the problems loaded, and the optimizer's label

LOSSES = (TimeExceededError, MemoryExceededError, PrintedTooMuchError, DiedError, RemoteError)


class Templates:
    """A job's tree of processes; one thread uses it, and any may :meth:`kill` it.

    All methods raise what :meth:`bench.sandbox.process.Process.call` raises.

    Args:
        study: the frozen study.
        hash_seed: PYTHONHASHSEED of the processes, which orders sets of strings.
        timeout: wall seconds that a trial may take.
        memory: bytes that a process may hold.
        strictly: whether optimizers run in processes that hold no problem (:meth:`make_strictly`).
        command: the words of a sandbox's command line.
    """

    def __init__(
        self,
        study: Study,
        hash_seed: int,
        timeout: float | None,
        memory: int | None,
        *,
        strictly: bool = False,
        command: Sequence[str] = (),
    ) -> None:
        self._timeout, self._memory, self._strict = timeout, memory, strictly
        self._loading = None if timeout is None else timeout + LOADING
        self._silence = None if timeout is None else max(timeout, SILENCE)
        self._families = {entry.label: loading.family(entry.name) for entry in study.problems}
        self._sources = {entry.label: loading.package(entry.name) for entry in study.with_controls}
        self._root = Process(hash_seed, forks=True, command=command)
        try:
            self._root.call(trial_process.begin, study.to_toml())
        except BaseException:
            self._root.close()
            raise
        self._boxes: dict[str, Box | str] = {}
        self._problems: dict[str, Process] = {}
        self._judges: dict[str, Process] = {}
        self._packages: dict[Key, tuple[Process, set[str]]] = {}  # with the optimizers loaded there
        self._optimizers: OrderedDict[Key, tuple[Process, set[str]]] = OrderedDict()  # with the problems warmed up on
        self._trials: dict[Process, tuple[Process, float]] = {}  # by template, with the seconds left for trials there
        self._sandboxed = bool(command)
        self._core = next(_cores)  # of strict trials
        self._alone: set[str] = set()  # labels whose loading has ended a process that others would share
        self._cold: set[Key] = set()  # optimizers whose warm-up has ended their process: it is not repeated

    def close(self) -> None:
        """End all processes."""
        for trial, _ in self._trials.values():
            with suppress(Exception):
                trial.close()
        self._root.close()

    def kill(self) -> None:
        """End all processes; any thread may do so, and the call under way then finds its process ended."""
        self._root.kill()

    def box(self, problem: str) -> Box | str:
        """Return a problem's variables and bounds, or the error of loading it."""
        self._loaded_problems(problem)
        return self._boxes[problem]

    def prepare(self, trial: Trial) -> Process:
        """Load and warm up what a trial needs, as far as that has not been done; return the template of its process."""
        template = self._warm(trial.problem, trial.optimizer)
        self._tidy()
        return template

    def make(self, trial: Trial, template: Process) -> tuple[Any, float]:
        """Have a trial made; return what its process answers, which is not to be believed, and the seconds it took."""
        if template in self._trials:
            process, left = self._trials.pop(template)
        else:
            began = monotonic()
            process = template.fork()
            left = WORTH * (monotonic() - began)
        began = monotonic()
        try:
            answer = process.call(
                trial_process.make, trial, seconds=self._timeout, memory=self._memory, printed=PRINTED, again=False
            )
        except RemoteError:
            process.close()
            raise
        took = monotonic() - began
        sound = isinstance(answer, dict) and answer.get("altered") is False
        if sound and took < left and not self._sandboxed:
            self._trials[template] = process, left - took
        else:
            process.close()
        self._tidy()
        return answer, took

    def make_strictly(self, trial: Trial, template: Process) -> tuple[Any, float]:
        """Have a trial made whose problem, budget and trace are in another process than its optimizer.

        Return what the other process answers, with the processor seconds of the optimizer's, and the seconds it took.
        """
        _, problems = self._loaded_problems(trial.problem)
        box = self._boxes[trial.problem]
        assert isinstance(box, Box)
        bounds = box.lower.tolist(), box.upper.tolist(), box.integer.tolist()
        with problems.fork() as keeper, template.fork() as process:
            one, other = socket.socketpair()
            with one, other:
                keeper.start(trial_process.keep, trial, self._core, files=[one.fileno()])
                process.start(trial_process.make_strictly, trial, self._core, *bounds, files=[other.fileno()])
            began = monotonic()
            answer = process.finish(seconds=self._timeout, memory=self._memory, printed=PRINTED)
            took = monotonic() - began
            process.close()  # before the keeper is asked, as a thread may go on
            if isinstance(answer, dict) and "error" in answer:
                return answer, took
            self._tidy()
            kept = keeper.finish(seconds=self._timeout, memory=self._memory)
            cpu = answer.get("cpu_s") if isinstance(answer, dict) else None
            return (kept | {"cpu_s": cpu} if isinstance(kept, dict) else kept), took

    def evaluate(self, points: Sequence[tuple[str, list[float]]], *, anew: bool = False) -> list[Any]:
        """Return the values and the metrics of points, each of a problem, from processes in which no optimizer runs.

        With ``anew`` the processes are new ones, in case a problem has changed the others, and each point is evaluated
        in batches too.
        """
        found: list[Any] = [None] * len(points)
        families: dict[str, list[int]] = {}
        for number, (problem, _) in enumerate(points):
            families.setdefault(self._loaded_problems(problem)[0], []).append(number)
        for family, numbers in families.items():
            judge = self._judges.pop(family, None)
            if judge is not None and anew:
                judge.close()
                judge = None
            judge = judge or self._problems[family].fork()
            try:
                answer = judge.call(
                    trial_process.evaluate, [points[each] for each in numbers], anew,
                    seconds=self._timeout, memory=self._memory, again=False,
                )  # fmt: skip
            except RemoteError:
                judge.close()
                raise
            self._judges[family] = judge
            if isinstance(answer, list) and len(answer) == len(numbers):
                for number, each in zip(numbers, answer, strict=True):
                    found[number] = each
        return found

    def _loaded_problems(self, problem: str) -> tuple[str, Process]:
        """Return the family of a problem, or its label where it is loaded alone, and the process that holds them."""
        family = problem if problem in self._alone else self._families[problem]
        if family not in self._problems:
            labels = [
                label
                for label, own in self._families.items()
                if label == problem or (own == family and label not in self._alone)
            ]
            process = self._root.fork()
            try:
                found = process.call(trial_process.load_problems, labels, seconds=self._loading, memory=self._memory)
            except LOSSES:
                process.close()
                if problem in self._alone:
                    raise
                self._alone.update(labels)
                return self._loaded_problems(problem)
            self._problems[family] = process
            self._boxes |= boxes(found, labels)
        return family, self._problems[family]

    def _loaded_optimizer(self, family: str, base: Process, optimizer: str) -> Process:
        """Return the process that has loaded an optimizer, with others of its package unless that went wrong."""
        package = optimizer if optimizer in self._alone else self._sources[optimizer]
        held = self._packages.pop((family, package), None)
        process, loaded = held if held and not held[0].closed else (base.fork(), set())
        if self._strict and not loaded:
            process.call(strict.hide_problems)
        if optimizer not in loaded:
            try:
                process.call(trial_process.load_optimizer, optimizer, seconds=self._loading, memory=self._memory)
            except LOSSES:
                process.close()
                for key in [key for key, (each, _) in self._optimizers.items() if each.closed]:  # with their package's
                    self._end_trial(self._optimizers.pop(key)[0])
                if optimizer in self._alone:
                    raise
                self._alone.add(optimizer)
                return self._loaded_optimizer(family, base, optimizer)
            loaded.add(optimizer)
        self._packages[family, package] = process, loaded
        return process

    def _warm(self, problem: str, optimizer: str) -> Process:
        """Return a process that has made a short trial of the optimizer on this kind of problem."""
        family, base = self._loaded_problems(problem)
        if self._strict:
            family, base = "", self._root
        key = family, optimizer
        loaded = self._loaded_optimizer(family, base, optimizer)
        held = self._optimizers.pop(key, None)
        if held and held[0].closed:  # it answered in place of the harness when it was to be forked
            self._end_trial(held[0])
            self._cold.add(key)
            held = None
        process, warm = held or (loaded.fork(), set())
        if problem not in warm and key not in self._cold:
            box = self._boxes[problem]
            what: tuple[Any, ...] = (trial_process.warm_up, problem, optimizer)
            if self._strict and isinstance(box, Box):
                what = (trial_process.warm_up_strictly, optimizer, box.lower.tolist(), box.upper.tolist())
            try:
                warmed = process.call(
                    *what, seconds=self._loading, silence=self._silence, memory=self._memory, printed=PRINTED
                )
            except LOSSES:
                self._drop(process)
                self._cold.add(key)
                process, warm = loaded.fork(), set()
            else:
                if warmed:  # a trial process must be as warm as its template
                    self._end_trial(process)
                warm.add(problem)
        self._optimizers[key] = process, warm
        while len(self._optimizers) > KEPT:
            _, (oldest, _) = self._optimizers.popitem(last=False)
            self._drop(oldest)
        return process

    def _tidy(self) -> None:
        """Let a trial find nothing that another one has written in the sandbox."""
        if self._sandboxed:
            self._root.call(bubblewrap.empty_scratch)

    def _drop(self, template: Process) -> None:
        """End the template of an optimizer, and its trial process."""
        self._end_trial(template)
        _close(template)

    def _end_trial(self, template: Process) -> None:
        """End the trial process of an optimizer."""
        if template in self._trials:
            _close(self._trials.pop(template)[0])


def _close(process: Process) -> None:
    with suppress(LostError, RemoteError):  # of an optimizer that may not have the present turn
        process.close()
