"""The processes of one job; each optimizer runs in processes in which no other has run.

    root            trusted code only
    └ problems      of one family, loaded
      └ optimizers  of one package or file, loaded
        └ optimizer warmed up
          └ trial   makes trials of this optimizer until they have taken WORTH times as long as its start, and
                    evaluates their best points again

Each is forked from the one before it and shares the memory of what is loaded; where processes do not fork, each is
started anew and loads all that the one before it holds. Where problem, budget and trace are kept apart from the
optimizer, a process makes one trial, and optimizers' processes come from a root that loads no problem. All processes of
code that nobody trusts are in a sandbox, each with namespaces of its own.
"""

from __future__ import annotations

import json
import socket
import sys
from collections import OrderedDict
from collections.abc import Iterable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from pathlib import Path
from time import monotonic
from typing import Any

from bench.contract.objective import ON_TARGET, OUT_OF_TIME
from bench.execution import answers, apart, trial_process
from bench.execution.answers import Box, RefusedError
from bench.helpers.errors import PROBLEM_FAILED
from bench.helpers.parsing import JsonObject
from bench.helpers.text import printable
from bench.plugins import from_file, loading, objects, registry
from bench.plugins.inputs import named
from bench.plugins.observing import PARTS, Observed, Signature
from bench.plugins.packing import Objects
from bench.sandbox import bubblewrap
from bench.sandbox.forks import ForkServer
from bench.sandbox.process import FAILURES, Process
from bench.storage import provenance
from bench.study import Entry, Study
from bench.trial.trial import Trial

LOADING = 300.0  # seconds for loading plug-ins, for a warm-up, and for evaluating a point
WARMING = 20.0  # least seconds of a warm-up, in which code may be compiled, where a trial may take fewer
PRINTED = 1_000_000  # bytes that a trial may print: they are discarded, but writing them takes time from other trials
KEPT = 64  # warmed-up optimizers of a job at most; more are warmed up again when their turn comes
WORTH = 50.0  # times the seconds of its start: a process is replaced once its trials have taken longer
TIMEOUT, MEMORY = 600.0, 4_000_000_000  # wall seconds and bytes of a trial of code that nobody trusts, unless given
BATCHES = 100.0  # times the seconds of a trial, which has evaluated at least one point: more than its point takes again


@dataclass(frozen=True)
class Task:
    """The settings that all trials of a run share."""

    study: Study  # as frozen in its folder; processes load its plug-ins by name
    timeout: float | None = None  # wall seconds that a trial may take
    memory: int | None = None  # bytes that a trial's process may hold
    hash_seed: int = 0  # PYTHONHASHSEED of the processes, which orders sets of strings
    apart: bool = False  # whether problem, budget and trace are kept in another process than the optimizer
    untrusted: bool = False  # whether they are, all processes run in a sandbox, and trials have limits by default
    package: str = field(default_factory=provenance.package)  # of the parent; a worker with another one is refused
    output: str = ""  # the folder of results, which are no inputs
    known: dict[str, tuple[str, Signature]] = field(default_factory=dict)  # hashes of large files, with signatures
    objects: Objects = field(default_factory=dict)  # of a session, which every process takes

    @classmethod
    def of(cls, study: Study, **settings: Any) -> Task:
        """Return the task of a study, with those of its plug-ins that are objects of this session."""
        optimizers, problems = ([entry.name for entry in every] for every in (study.optimizers, study.problems))
        return cls(study, objects=objects.among(optimizers, problems), **settings)

    def beginning(self, *, without_problems: bool = False) -> tuple[Any, ...]:
        """Return the call with which a process begins; it may hold nothing of the study's problems."""
        arguments = self.study, self.objects, self.output, self.known
        if without_problems:
            held = {key: each for key, each in self.objects.items() if key.startswith("optimizers ")}
            arguments = replace(self.study, problems=()), held, self.output, {}
        return trial_process.begin, *arguments

    def __post_init__(self) -> None:
        if self.untrusted:
            object.__setattr__(self, "apart", True)
            object.__setattr__(self, "timeout", self.timeout or TIMEOUT)
            object.__setattr__(self, "memory", self.memory or MEMORY)


class Job:
    """A job's processes; one thread uses them, and any may :meth:`kill` them.

    All methods raise what :meth:`bench.sandbox.process.Process.call` raises.

    Args:
        task: what all trials have in common.
        first: the root of its processes; None for a new one.
        checked: a branch of it that has loaded all problems, of use where they are of one family; None for none.
    """

    def __init__(self, task: Task, first: ForkServer | None = None, checked: ForkServer | None = None) -> None:
        self._task, study = task, task.study
        self._limits: dict[str, Any] = {"seconds": task.timeout, "memory": task.memory}  # of a trial
        self._loading = self._limits | {"seconds": LOADING}
        warming = min(LOADING, max(task.timeout or LOADING, WARMING))
        self._warming = self._loading | {"seconds": warming, "printed": PRINTED}
        self.doing = ""  # beside the trial itself, for messages
        self._families = {entry.label: loading.family(entry.name) for entry in study.problems}
        self._packages = {entry.label: loading.package(entry.name) for entry in study.optimizers}
        self._root = first or root(task)
        self._checked = checked
        if checked is not None and len({*self._families.values()}) > 1:
            checked.close()
            self._checked = None
        self._alone = root(task, without_problems=True) if task.apart else self._root
        self._boxes: dict[str, Box | str] = {}
        self._read: dict[str, dict[str, Observed]] = {}  # what processes have read, by its digest
        self._inputs: dict[tuple[str, str, str], str] = {}  # of it as JSON, by problem and optimizer
        self._named = {entry.label: named_by(entry) for entry in (*study.problems, *study.optimizers)}
        self._problems: dict[str, ForkServer] = {}  # one for all problems of a family that can be loaded together
        self._loaded: dict[tuple[ForkServer, str], ForkServer] = {}  # by the problems and the package of the optimizers
        self._ready: OrderedDict[tuple[ForkServer, str], _Ready] = OrderedDict()  # by the problems and the optimizer

    def kill(self) -> None:
        """End all processes; any thread may do so, and the call under way then finds its process ended."""
        for server in (self._root, self._alone):
            server.kill()

    def box(self, problem: str) -> Box | str:
        """Return a problem's variables and bounds, or the error of loading it."""
        self._with_problem(problem)
        return self._boxes[problem]

    def prepare(self, trial: Trial) -> _Ready:
        """Load and warm up what a trial needs, by a short trial on a stand-in for the problem, unless that is done."""
        problem, optimizer = trial.problem, trial.optimizer
        problems = self._alone if self._task.apart else self._with_problem(problem)
        ready = self._ready.pop((problems, optimizer), None)
        if ready is None:
            ready = _Ready(self._with_optimizer(problems, optimizer).branch())
        if problem not in ready.problems:
            ready.problems.add(problem)
            try:
                if ready.server.call(trial_process.warm_up, optimizer, self._boxes[problem], **self._warming):
                    ready.end_process()  # it must be as warm as others
            except FAILURES:  # the trials will fail with the reason
                ready.end_process()
                ready.server = self._with_optimizer(problems, optimizer).branch()
        self._ready[problems, optimizer] = ready
        while len(self._ready) > KEPT:
            _, oldest = self._ready.popitem(last=False)
            oldest.end_process()
            oldest.server.close()
        return ready

    def make(self, trial: Trial, ready: _Ready, held: Objects) -> Any:
        """Have a trial made, by what is ``held`` in the place of its plug-ins, where the problem is kept apart.

        Return what its process answers, which is not to be believed.
        """
        if self._task.apart:
            return self._make_apart(trial, ready, held)
        began = monotonic()
        if trial.again:
            ready.end_process()
        if ready.process is None or ready.process.closed:
            ready.process, ready.made = ready.server.process(), set()
            ready.left = WORTH * (monotonic() - began)
        ready.made.add(trial.problem)
        began = monotonic()
        answer = ready.process.call(trial_process.make, trial, **self._limits, printed=PRINTED)
        took = monotonic() - began
        ready.left -= took
        sound = isinstance(answer, dict) and answer.get("altered") is False
        if isinstance(answer, dict) and "error" not in answer:
            self.doing = "while its best point was evaluated again"
            limits = self._limits | {"seconds": LOADING + BATCHES * took}
            again = ready.process.call(trial_process.confirm, trial.problem, **limits)
            answer = answer | again if isinstance(again, dict) else again
            self._note(answer, trial)
        if not sound or ready.left <= 0:
            ready.process.close()
        return answer

    def _make_apart(self, trial: Trial, ready: _Ready, held: Objects) -> object:
        """Have a trial made by :func:`make_apart`; return the answer, with what both processes have read.

        What a ``held`` optimizer has read is not kept: another one takes its place.
        """
        with self._with_problem(trial.problem).process() as server, ready.server.process() as process:
            if held:
                process.call(trial_process.hold, held, **self._limits)
            kept = make_apart(trial, self._boxes[trial.problem], server, process, self._limits)
        if isinstance(kept, dict) and "error" not in kept and not held:
            optimizer = kept.pop("beside")
            for answer in (kept, optimizer):
                self._note(answer, trial)
            read = {"problem": kept, "optimizer": optimizer}
            kept["inputs"] = json.dumps({part: json.loads(each["inputs"])[part] for part, each in read.items()})
        return kept

    def _note(self, answer: JsonObject, trial: Trial) -> None:
        """Put what a trial was made from in the place of its digest.

        Raises:
            RefusedError: for an answer of another form, which plug-in code wrote in place of the harness.
        """
        digest, labels = str(answer.get("inputs")), trial.key[:2]
        if "read" in answer:
            self._read[digest] = answer["read"]
        if (digest, *labels) not in self._inputs:
            own = {name for label in labels for name in self._named[label]}
            others = {name for names in self._named.values() for name in names} - own
            try:
                found = {part: named(self._read[digest].get(part, {}), labels) for part in PARTS}
            except (AttributeError, KeyError, OSError, TypeError, ValueError) as error:
                raise RefusedError("what it has read cannot be read") from error
            if self._task.untrusted:  # a sandbox has few variables
                others |= {name for inputs in found.values() for name in inputs if name.startswith("variable:")}
            left = {part: {n: known for n, known in each.items() if n not in others} for part, each in found.items()}
            self._inputs[digest, *labels] = json.dumps(left)
        answer["inputs"] = self._inputs[digest, *labels]

    def _with_problem(self, problem: str) -> ForkServer:
        """Return the server of processes that have loaded a problem, and the others of its family where they can."""
        if problem not in self._problems:
            server, self._checked = self._checked or self._root.branch(), None
            self._load_problem(problem, server)
            for label, family in self._families.items():
                if family == self._families[problem] and label not in self._problems:
                    with suppress(*FAILURES, RefusedError):  # it will be loaded alone
                        self._load_problem(label, server)
        return self._problems[problem]

    def _load_problem(self, label: str, server: ForkServer) -> None:
        described = server.call(trial_process.load_problem, label, **self._loading)
        self._boxes[label] = printable(described, 4000) if isinstance(described, str) else Box.of(described)
        self._problems[label] = server

    def _with_optimizer(self, problems: ForkServer, optimizer: str) -> ForkServer:
        """Return the server of processes that have loaded an optimizer, and others of its package, beside problems."""
        package = self._packages[optimizer] if problems.forks else optimizer
        server = self._loaded.get((problems, package))
        if server is None:
            server = self._loaded[problems, package] = problems.branch()
        if self._task.apart:
            server.ensure(apart.hide_problems, **self._loading)
        server.ensure(trial_process.load_optimizer, optimizer, **self._loading)
        return server


def make_apart(
    trial: Trial,
    box: Box | str,
    server: Process,
    process: Process,
    limits: dict[str, Any],
) -> object:
    """Have a trial made whose problem, budget and trace are in another process than its optimizer.

    Return what the process of the problem answers, with the processor seconds of the optimizer's, the reason to stop
    that it declared, and the optimizer's own answer ``beside`` it.

    Args:
        trial: the trial.
        box: that of its problem.
        server: the process of the problem.
        process: that of the optimizer, which is closed.
        limits: of the trial (:meth:`bench.sandbox.process.Process.finish`).
    """
    server_end, optimizer_end = socket.socketpair()
    with server_end, optimizer_end:
        server.start(trial_process.serve, trial, files=[server_end.fileno()])
        process.start(trial_process.make, trial, box, files=[optimizer_end.fileno()])
    began = monotonic()
    answer = process.finish(**limits, printed=PRINTED, beside=[server])
    took = monotonic() - began
    process.close()  # before the server is asked, as a thread may go on
    lost = not isinstance(answer, dict) or "error" in answer
    kept = None
    with suppress(*FAILURES) if lost else nullcontext():  # it knows alone whether the problem has failed
        kept = server.finish(seconds=LOADING + BATCHES * took, memory=limits["memory"])
    if isinstance(kept, dict) and "error" in kept:
        return kept
    if lost:  # its problem denies that it has failed
        return {"error": answers.error(answer).removeprefix(PROBLEM_FAILED)}
    if isinstance(kept, dict):
        kept |= {key: answer.get(key) for key in ("cpu_s", "memory_mb", "log", "unasked")} | {"beside": answer}
        if kept.get("stop") not in ("budget", OUT_OF_TIME, ON_TARGET):
            declared = answer.get("stop")
            kept["stop"] = "undeclared" if declared in (OUT_OF_TIME, ON_TARGET) else declared
    return kept


def named_by(entry: Entry) -> set[str]:
    """Return the files that an entry of a study names, as inputs: no other entry is made from them."""
    name = entry.name
    words = [name.partition(":")[2], name.rpartition(":")[0], *map(str, entry.options.values()), *entry.files]
    with suppress(OSError, ValueError):  # of a word that is no name of a file
        files = [Path(word).absolute() for word in words if word and Path(word).is_file()]
        return {*named({"": {"files": {str(file): ["", []] for file in files}}})}
    return set()


@dataclass
class _Ready:
    """An optimizer that is loaded and warmed up."""

    server: ForkServer
    problems: set[str] = field(default_factory=set)  # that it was warmed up for
    process: Process | None = None  # makes its trials, as long as they take less than the seconds left
    left: float = 0.0
    made: set[str] = field(default_factory=set)  # problems of the trials that this process has made

    def before(self, problem: str) -> int:
        """Return 2 where the next trial's process has made one of the problem, 1 where one of another, 0 for none."""
        return 0 if self.process is None or self.process.closed else 1 + (problem in self.made)

    def end_process(self) -> None:
        if self.process is not None:
            self.process.close()


def root(task: Task, *, without_problems: bool = False) -> ForkServer:
    """Return the server of a task's processes; of code that nobody trusts, in the sandbox of :func:`sandbox_of`."""
    server = ForkServer(task.hash_seed, sandbox=sandbox_of(task, without_problems=without_problems))
    return server.after(*task.beginning(without_problems=without_problems), seconds=LOADING)


def sandbox_of(task: Task, *, without_problems: bool = False) -> bubblewrap.Sandbox | None:
    """Return the sandbox of code that nobody trusts; raises BenchError where there is none.

    Processes ``without_problems`` find no problem in the sandbox, and nothing beside the code that they need.
    """
    if not task.untrusted:
        return None
    optimizers, problems = ([entry.name for entry in every] for every in (task.study.optimizers, task.study.problems))
    if not without_problems:
        return sandbox([*optimizers, *problems])
    hidden = {*_named(problems)} - {*_named(optimizers)}  # a file may hold both
    hidden |= {Path(task.output)} if task.output else set()
    return sandbox_of_optimizers(optimizers, hidden)


def sandbox_of_optimizers(names: Iterable[str], hidden: Iterable[Path] = ()) -> bubblewrap.Sandbox:
    """Return the sandbox for optimizers of these names, where nothing can be read but the code that they need.

    Args:
        names: of the optimizers.
        hidden: files and folders that they must not read wherever they lie; the files of installed problems are others.

    Raises:
        BenchError: where there is none.
    """
    hidden = [*apart.problem_files(), *hidden]
    return bubblewrap.find(shown=_files(names), only=_code(), hidden=hidden, kernels=_kernels({"bench"}))


def sandbox(names: Iterable[str]) -> bubblewrap.Sandbox:
    """Return the sandbox for plug-ins of these names; raises BenchError where there is none."""
    return bubblewrap.find(shown=_files(names), kernels=_kernels({"bench", *_tops("problems")}))


def _code() -> set[Path]:
    """Return the folders that Python, its packages, this one and the optimizers are imported from.

    A folder beside those of installed packages, such as a checkout, is left out where it holds the code of problems.
    """
    problems = [*apart.problem_files()]
    folders = [Path(sys.prefix), Path(sys.base_prefix), Path(sys.executable).resolve().parents[1]]
    for folder in (Path(folder) for folder in sys.path if folder):
        if folder.name.endswith("-packages") or not any(folder.resolve() in file.parents for file in problems):
            folders.append(folder)
    modules = {
        "bench",
        *_tops("optimizers"),
        *_tops("problems"),
    }  # a package of problems is empty: its files are hidden
    return {path for folder in folders for path in (folder.absolute(), folder.resolve())} | {*_packages(modules)}


def _tops(group: str) -> set[str]:
    """Return the outermost packages of the plug-ins that are installed in a group."""
    return {entry.module.partition(".")[0] for entry in registry.entries(group).values()}


def _packages(modules: Iterable[str]) -> Iterator[Path]:
    """Yield the folders of packages, and the files of other modules."""
    for module in modules:
        spec = find_spec(module)
        if spec is not None:
            places = spec.submodule_search_locations or ([spec.origin] if spec.origin else [])
            yield from map(Path, places)


def _kernels(modules: Iterable[str]) -> Iterator[Path]:
    """Yield the files of numba's caches beside the code of these packages."""
    for folder in _packages(modules):
        yield from folder.rglob("__pycache__/*.nb[ci]")


def _named(names: Iterable[str]) -> Iterator[Path]:
    """Yield the files that plug-ins are named by, those of recordings included."""
    for name in names:
        named = from_file.split(name)
        path = named[0] if named else Path(name.partition(":")[2])
        if path.is_file():
            yield path.absolute()


def _files(names: Iterable[str]) -> Iterator[Path]:
    """Yield the files that plug-ins are named by, and the modules and packages beside them."""
    for path in _named(names):
        yield path
        yield from path.parent.glob("*.py")
        for package in {file.parent for file in path.parent.glob("*/*.py")}:
            yield from package.rglob("*.py")
