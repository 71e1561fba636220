"""The processes of one job; each optimizer runs in processes in which no other has run.

    root            trusted code only
    └ problems      of one family, loaded
      ├ evaluator   evaluates best points again
      └ optimizers  of one package or file, loaded
        └ optimizer warmed up
          └ trial   makes trials of this optimizer until they have taken WORTH times as long as its start

Each is forked from the one before it and shares the memory of what is loaded; where processes do not fork, each is
started anew and loads all that the one before it holds. In a sandbox, all that hold an optimizer have namespaces of
their own, and a process makes one trial.
"""

from __future__ import annotations

import socket
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from itertools import count
from pathlib import Path
from time import monotonic
from typing import Any

from bench.execution import strict, trial_process
from bench.execution.answers import Box, boxes
from bench.plugins import from_file, loading
from bench.sandbox import bubblewrap
from bench.sandbox.forks import ForkServer
from bench.sandbox.process import FAILURES, Process, RemoteError
from bench.study import Study
from bench.trial import Trial

LOADING = 300.0  # seconds for loading plug-ins, for a warm-up, and for evaluating a point
SILENCE = 3.0  # least seconds of a warm-up in which nothing is imported or compiled
PRINTED = 1_000_000  # bytes that a trial may print: they are discarded, but writing them takes time from other trials
KEPT = 64  # warmed-up optimizers; more are warmed up again when their turn comes
WORTH = 50.0  # times the seconds of its start: a process is replaced once its trials have taken longer
BATCHES = 100.0  # times the seconds of a trial, which has evaluated at least one point: more than its point takes again

_cores = count()


class Job:
    """A job's processes; one thread uses them, and any may :meth:`kill` them.

    All methods raise what :meth:`bench.sandbox.process.Process.call` raises.

    Args:
        study: the frozen study.
        hash_seed: PYTHONHASHSEED of the processes, which orders sets of strings.
        timeout: wall seconds that a trial may take.
        memory: bytes that a process may hold.
        strictly: whether optimizers run in processes that hold no problem.
        sandbox: the name of a sandbox in which all processes run.
    """

    def __init__(
        self, study: Study, hash_seed: int, timeout: float | None, memory: int | None, *, strictly: bool = False,
        sandbox: str | None = None,
    ) -> None:  # fmt: skip
        self._study, self._timeout, self._memory, self._strict = study, timeout, memory, strictly
        self._loading: dict[str, Any] = {"seconds": LOADING, "memory": memory}
        self._silence = None if timeout is None else max(timeout, SILENCE)
        self._families = {entry.label: loading.family(entry.name) for entry in study.problems}
        self._packages = {entry.label: loading.package(entry.name) for entry in study.with_controls}
        self._core = next(_cores)  # of strict trials
        self._root = self._alone = root(study, sandbox, hash_seed=hash_seed)
        if sandbox and strictly:  # the optimizers' processes come from another one, where no problem can be read
            self._alone = root(study, sandbox, hash_seed=hash_seed, apart=True)
        self._begun = False
        self._boxes: dict[str, Box | str] = {}
        self._problems: dict[str, ForkServer] = {}  # by family, or by label where one is loaded alone
        self._evaluators: dict[str, Process] = {}
        self._loaded: dict[tuple[str, str], tuple[ForkServer, set[str]]] = {}  # with the optimizers loaded there
        self._warm: OrderedDict[tuple[str, str], tuple[ForkServer, set[str]]] = OrderedDict()  # with the problems
        self._trials: dict[ForkServer, tuple[Process, float]] = {}  # with the seconds left for trials there
        self._apart: set[str] = set()  # labels whose loading has ended a process that others would share
        self._sandboxed = bool(sandbox)

    def kill(self) -> None:
        """End all processes; any thread may do so, and the call under way then finds its process ended."""
        for each in (self._root, self._alone):
            each.kill()

    def box(self, problem: str) -> Box | str:
        """Return a problem's variables and bounds, or the error of loading it."""
        self._with_problem(problem)
        return self._boxes[problem]

    def prepare(self, trial: Trial) -> ForkServer:
        """Load and warm up what a trial needs, as far as that has not been done; return what starts its process."""
        return self._warmed_up(trial.problem, trial.optimizer)

    def make(self, trial: Trial, server: ForkServer) -> tuple[Any, float]:
        """Have a trial made; return what its process answers, which is not to be believed, and the seconds it took."""
        began = monotonic()
        process, left = self._trials.pop(server, (None, 0.0))
        if process is None or process.closed:
            process = server.process()
            left = WORTH * (monotonic() - began)
        began = monotonic()
        try:
            answer = process.call(
                trial_process.make, trial, seconds=self._timeout, memory=self._memory, printed=PRINTED
            )
        except RemoteError:
            process.close()
            raise
        took = monotonic() - began
        sound = isinstance(answer, dict) and answer.get("altered") is False
        if sound and took < left and not self._sandboxed:
            self._trials[server] = process, left - took
        else:
            process.close()
        return answer, took

    def make_strictly(self, trial: Trial, optimizers: ForkServer) -> tuple[Any, float]:
        """Have a trial made whose problem, budget and trace are in another process than its optimizer.

        Return what the other process answers, with the processor seconds of the optimizer's, and the seconds it took.
        """
        _, problems = self._with_problem(trial.problem)
        box = self._boxes[trial.problem]
        assert isinstance(box, Box)
        bounds = box.lower.tolist(), box.upper.tolist(), box.integer.tolist()
        with problems.process() as server, optimizers.process() as process:
            one, other = socket.socketpair()
            with one, other:
                server.start(trial_process.serve, trial, self._core, files=[one.fileno()])
                process.start(trial_process.make_strictly, trial, self._core, *bounds, files=[other.fileno()])
            began = monotonic()
            limits: dict[str, Any] = {"seconds": self._timeout, "memory": self._memory}
            answer = process.finish(**limits, printed=PRINTED, beside=[server])
            took = monotonic() - began
            process.close()  # before the server is asked, as a thread may go on
            if isinstance(answer, dict) and "error" in answer:
                return answer, took
            kept = server.finish(seconds=LOADING + took, memory=self._memory)
            cpu = answer.get("cpu_s") if isinstance(answer, dict) else None
            return (kept | {"cpu_s": cpu} if isinstance(kept, dict) else kept), took

    def evaluate(self, points: Sequence[tuple[str, list[float]]], seconds: float, *, anew: bool = False) -> list[Any]:
        """Return the values and the metrics of points, each of a problem, from processes in which no optimizer runs.

        Args:
            points: labels of problems and points.
            seconds: that the trials took which have evaluated them.
            anew: whether to take new processes, in case a problem has changed the others, and to evaluate each point in
                batches too.
        """
        found: list[Any] = [None] * len(points)
        families: dict[str, list[int]] = {}
        for number, (problem, _) in enumerate(points):
            families.setdefault(self._with_problem(problem)[0], []).append(number)
        for family, numbers in families.items():
            evaluator = self._evaluators.pop(family, None)
            if evaluator is not None and anew:
                evaluator.close()
                evaluator = None
            if evaluator is None or evaluator.closed:
                evaluator = self._problems[family].process()
            try:
                answer = evaluator.call(
                    trial_process.evaluate, [points[each] for each in numbers], anew,
                    seconds=LOADING + BATCHES * seconds, memory=self._memory,
                )  # fmt: skip
            except RemoteError:
                evaluator.close()
                raise
            self._evaluators[family] = evaluator
            if isinstance(answer, list) and len(answer) == len(numbers):
                for number, each in zip(numbers, answer, strict=True):
                    found[number] = each
        return found

    def _with_problem(self, problem: str) -> tuple[str, ForkServer]:
        """Return the family of a problem, or its label where it is loaded alone, and what starts processes with it."""
        family = problem if problem in self._apart else self._families[problem]
        if family not in self._problems:
            self._begin()
            labels = self._members(family)
            server = self._root.branch()
            try:
                found = server.call(trial_process.load_problems, labels, **self._loading)
            except FAILURES:
                if problem in self._apart:
                    raise
                self._apart.update(labels)
                return self._with_problem(problem)
            self._problems[family] = server
            self._boxes |= boxes(found, labels)
        return family, self._problems[family]

    def _members(self, family: str) -> list[str]:
        """Return the labels of the problems of a family that are loaded together."""
        return [
            label
            for label, own in self._families.items()
            if label == family or (own == family and label not in self._apart)
        ]

    def _begin(self) -> None:
        """Set the study of all processes."""
        if not self._begun:
            for each in {self._root, self._alone}:
                each.call(trial_process.begin, self._study, **self._loading)
            self._begun = True

    def _with_optimizer(self, problem: str, optimizer: str) -> ForkServer:
        """Return what starts processes that have loaded an optimizer, and the others of its package where it can."""
        family, problems = ("", self._alone) if self._strict else self._with_problem(problem)
        package = self._packages[optimizer] if problems.forks and optimizer not in self._apart else optimizer
        server, loaded = self._loaded.get((family, package), (None, set[str]()))
        if server is None:
            server = problems.branch(apart=True)
            if self._strict:
                server.call(strict.hide_problems, **self._loading)
        if optimizer not in loaded:
            try:
                server.call(trial_process.load_optimizer, optimizer, **self._loading)
            except FAILURES:
                if package == optimizer:
                    raise
                self._apart.add(optimizer)
                return self._with_optimizer(problem, optimizer)
            loaded.add(optimizer)
        self._loaded[family, package] = server, loaded
        return server

    def _warmed_up(self, problem: str, optimizer: str) -> ForkServer:
        """Return what starts processes that have made a short trial of the optimizer on this kind of problem."""
        family = "" if self._strict else self._with_problem(problem)[0]
        server, warm = self._warm.pop((family, optimizer), (None, set[str]()))
        if server is None:
            server = self._with_optimizer(problem, optimizer).branch()
        if problem not in warm:
            warm.add(problem)
            box = self._boxes[problem]
            what: tuple[Any, ...] = (trial_process.warm_up, problem, optimizer)
            if self._strict and isinstance(box, Box):
                what = (trial_process.warm_up_strictly, optimizer, box.lower.tolist(), box.upper.tolist())
            try:
                if server.call(*what, **self._loading, silence=self._silence, printed=PRINTED):
                    self._end_trials(server)  # a trial process must be as warm as others
            except FAILURES:  # the trials will fail with the reason
                self._end_trials(server)
                server = self._with_optimizer(problem, optimizer).branch()
        self._warm[family, optimizer] = server, warm
        while len(self._warm) > KEPT:
            _, (oldest, _) = self._warm.popitem(last=False)
            self._end_trials(oldest)
            oldest.close()
        return server

    def _end_trials(self, server: ForkServer) -> None:
        """End the trial process of an optimizer."""
        process, _ = self._trials.pop(server, (None, 0.0))
        if process is not None and not process.closed:
            process.close()


def root(study: Study, sandbox: str | None, *, hash_seed: int = 0, apart: bool = False) -> ForkServer:
    """Return what starts processes for a study, in a sandbox where one is named; raises BenchError as that does.

    With ``apart``, its processes find no installed problem in the sandbox.
    """
    hidden = strict.problem_files() if sandbox and apart else ()
    return ForkServer(hash_seed, sandbox=bubblewrap.find(sandbox, shown=_files(study), hidden=hidden))


def _files(study: Study) -> Iterator[Path]:
    """Yield the files that a study names: those of optimizers and of recordings."""
    for entry in (*study.with_controls, *study.problems):
        named = from_file.split(entry.name)
        path = named[0] if named else Path(entry.name.partition(":")[2])
        if path.is_file():
            yield path.absolute()
