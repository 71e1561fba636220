"""Run the implementations of an atlas, and look for parameters that change nothing.

Every run is made in a process of :mod:`bench.sandbox`, as those of :mod:`bench.check.runs`.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np

from bench.analysis.similarity import LEAST, STAGES, TRAITS, behaviour
from bench.atlas.table import Implementation, Method
from bench.check.conformance.subject import PRINTED
from bench.check.problems import FUNCTIONS, classic
from bench.check.runs import on_bound
from bench.check.verdict import LONGEST
from bench.errors import BenchError
from bench.execution.solve import make_run
from bench.helpers.text import printable
from bench.optimizer import CONDITIONS, Optimizer
from bench.plugins.loading import load_optimizer
from bench.sandbox.messages import describe_error
from bench.sandbox.pool import Pool
from bench.sandbox.process import FAILURES, DiedError, LostError
from bench.sandbox.server import STILL_ASKING
from bench.seeds import trial_seed
from bench.typing import Floats

DIMENSION = 5
TIMEOUT = 600.0  # seconds of one run
PLACES = ("centred", "moved")
PROBLEMS = tuple(f"{name} {place}" for name in FUNCTIONS for place in PLACES)
"""The ten functions: five classic ones, each with its optimum at the centre of the box and moved from there."""

PROBES = ("sphere moved", "Rastrigin moved")
"""The functions on which parameters are changed."""

MEASURES = ("start", "next", "course", "final")
"""What is tested of a trial: log10 of the median value of its first generation and of the two after it; the mean over
eighths of the budget of log10 of the best value so far; and the final best value. A method with a first generation of G
evaluations has G of them in ``start`` and the 2 G after these in ``next``."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Task:
    """One run: its problem, budget, seed, and the evaluations of a generation."""

    problem: str
    budget: int
    seed: int
    generation: int


@dataclass(frozen=True)
class Surveyed:
    """What was seen of an implementation.

    Attributes:
        implementation: the implementation.
        code: whose code ran, with its version.
        measures: by problem, (trials, measures) in the order of ``MEASURES``.
        behaviours: by problem, (trials, numbers); see :func:`bench.analysis.similarity.behaviour`.
        clamped: the share of the coordinates of the best points that lie exactly on a bound.
        evaluations: the median number of evaluations of a trial.
        repeatable: whether a seed repeats a run to the last bit.
        dead: parameters without any effect, with the other values that were tried, as text.
        microseconds: the median processor time of an evaluation, the function's included.
        failed: why the implementation was left out, "" where it ran; the attributes from ``measures`` on then mean
            nothing.
    """

    implementation: Implementation
    code: str = ""
    measures: Mapping[str, Floats] = dataclasses.field(default_factory=dict)
    behaviours: Mapping[str, Floats] = dataclasses.field(default_factory=dict)
    clamped: float = float("nan")
    evaluations: float = float("nan")
    repeatable: bool = True
    dead: Mapping[str, str] = dataclasses.field(default_factory=dict)
    microseconds: float = float("nan")
    failed: str = ""


def survey(
    methods: Sequence[Method],
    *,
    trials: int,
    budget: int,
    seed: int = 0,
    n_jobs: int = -1,
    on_progress: Progress = lambda *_: None,
) -> list[Surveyed]:
    """Run all implementations and return what was seen of each, in order.

    A trial's seed depends on its implementation, problem and number alone. An implementation that fails in any run, or
    whose library is missing, is returned with the reason.

    Args:
        methods: the methods.
        trials: of each implementation on each of ``PROBLEMS``.
        budget: evaluations of a trial.
        seed: repeats every number but times.
        n_jobs: runs made at a time; -1 takes every core. The numbers do not depend on it.
        on_progress: called with the current implementation, the runs done and all runs.
    """
    found: list[Surveyed] = []
    with Pool(n_jobs, ready) as pool:
        begun = [
            _Runs(pool, number, each, method, trials, budget, seed)
            for number, (method, each) in enumerate((m, each) for m in methods for each in m.implementations)
        ]
        total, done = sum(each.size for each in begun), 0
        for each in begun:
            found.append(each.result(lambda made, name=each.name, base=done: on_progress(name, base + made, total)))  # type: ignore[misc]
            done += each.size
    return found


class _Runs:
    """The runs of one implementation: all are submitted at once, and the results collected in order."""

    def __init__(
        self, pool: Pool, group: int, own: Implementation, method: Method, trials: int, budget: int, seed: int
    ) -> None:
        self._own, self.name, self._failed, self._code = own, own.key, "", ""
        self._begun: list[Future[Any]] = []
        self._probes: dict[str, Future[Any]] = {}
        tasks = [
            Task(problem, budget, trial_seed(seed, problem, own.key, trial), method.generation)
            for problem in PROBLEMS
            for trial in range(trials)
        ]
        try:
            optimizer = load_optimizer(own.name, **own.options)
            optimizer.check_budget(budget, own.label)
        except BenchError as error:
            self._failed = str(error)
        except Exception as error:  # a plug-in may raise anything
            self._failed = f"it cannot be loaded: {describe_error(error)}"
        else:
            self._code = optimizer.code
            self._values = alternatives(optimizer, method.technical)
            again = tasks[PROBLEMS.index(PROBES[0]) * trials]
            how = own.name, {**own.options}
            self._begun = [
                pool.submit(group, run, *how, task, seconds=TIMEOUT, printed=PRINTED) for task in [*tasks, again]
            ]
            probed = [tasks[PROBLEMS.index(each) * trials] for each in PROBES]
            self._probes = {
                name: pool.submit(group, probe, *how, name, values, probed, seconds=TIMEOUT, printed=PRINTED)
                for name, values in self._values.items()
            }
        self._again, self.size = PROBLEMS.index(PROBES[0]) * trials, len(self._begun) + len(self._probes)

    def result(self, on_made: Callable[[int], None]) -> Surveyed:
        """Wait for the runs; the first that fails ends the others."""
        if self._failed:
            return Surveyed(self._own, failed=printable(self._failed, LONGEST))
        rows: list[_Row] = []
        try:
            for each in self._begun:
                on_made(len(rows))
                rows.append(_answer(each))
        except BenchError as error:
            for each in (*self._begun, *self._probes.values()):
                each.cancel()
            return Surveyed(self._own, self._code, failed=str(error))
        repeatable = rows.pop()["points"] == rows[self._again]["points"]
        dead = {}
        for number, (name, each) in enumerate(self._probes.items(), len(rows) + 1):
            on_made(number)
            if tried := _without_effect(each, self._values[name]):
                dead[name] = tried
        measures, behaviours = (
            np.split(np.array([row[name] for row in rows]), len(PROBLEMS)) for name in ("measures", "behaviour")
        )
        return Surveyed(
            self._own,
            self._code,
            dict(zip(PROBLEMS, measures, strict=True)),
            dict(zip(PROBLEMS, behaviours, strict=True)),
            clamped=float(np.mean([row["clamped"] for row in rows])),
            evaluations=float(np.median([row["evaluations"] for row in rows])),
            repeatable=repeatable,
            dead=dead if repeatable else {},
            microseconds=float(np.median([1e6 * row.seconds / row["evaluations"] for row in rows])),
        )


def _without_effect(future: Future[Any], values: Sequence[Any]) -> str:
    """Return the values of a parameter that were tried, "" where any of them had an effect, or none could be tried."""
    try:
        tried = future.result()
    except (*FAILURES, LostError):  # of a value that the library cannot bear
        return ""
    known = isinstance(tried, list) and all(each in range(len(values)) for each in tried)
    return ", ".join(repr(values[each]) for each in tried) if known else ""


def alternatives(optimizer: Optimizer, technical: Sequence[str] = ()) -> dict[str, list[Any]]:
    """Return other values of each parameter of an optimizer but the conditions and technical ones, up to four.

    They are the other choices; of a number, the ends of its range, twice and half of it, and the next whole numbers. A
    parameter that is declared as not worth trying is left out, such as a tolerance that only ends a search.
    """
    hints = get_type_hints(type(optimizer))
    found = {}
    for each in dataclasses.fields(optimizer):  # type: ignore[arg-type]
        if each.name in (*CONDITIONS, *technical) or not each.init or each.metadata.get("tune") == []:
            continue
        now, hint = getattr(optimizer, each.name), hints[each.name]
        if isinstance(now, bool):
            values: list[Any] = [not now]
        elif get_origin(hint) is Literal:
            values = [choice for choice in get_args(hint) if choice is not None]
        elif isinstance(now, int | float):
            ends = [each.metadata.get(end) for end in ("minimum", "maximum")]
            values = [2 * now, now / 2, *(end for end in ends if end is not None), now + 1, now - 1]
            if isinstance(now, int) and hint is not float:
                values = [int(value) for value in values]
        else:
            continue
        others = [value for value in dict.fromkeys(values) if value != now and _accepted(optimizer, each.name, value)]
        if others:
            found[each.name] = others[:4]
    return found


def _accepted(optimizer: Optimizer, name: str, value: Any) -> bool:
    try:
        dataclasses.replace(optimizer, **{name: value})  # type: ignore[type-var]
    except Exception:  # a plug-in checks its parameters as it likes
        return False
    return True


def ready() -> None:
    """Load this module."""


def run(name: str, options: dict[str, Any], task: Task) -> dict[str, Any]:
    """Make one run in this process; return its numbers, or the error it ended with, as JSON values."""
    try:
        return measure(load_optimizer(name, **options), task)
    except BenchError as error:
        return {"error": str(error)}
    except (Exception, SystemExit) as error:  # a plug-in may raise anything
        return {"error": describe_error(error)}


def probe(name: str, options: dict[str, Any], parameter: str, values: list[Any], tasks: list[Task]) -> list[int]:
    """Make runs that differ in one parameter; return the places of the values tried, none where one had an effect.

    A value that the library refuses, or fails with, shows nothing and counts as not tried.
    """

    @cache
    def points(task: Task) -> str:
        return str(measure(load_optimizer(name, **options), task)["points"])

    tried = []
    for place, value in enumerate(values):
        try:
            changed = load_optimizer(name, **{**options, parameter: value})
            if any(measure(changed, task)["points"] != points(task) for task in tasks):
                return []
        except (Exception, SystemExit):  # a plug-in may raise anything
            continue
        tried.append(place)
    return tried


def measure(optimizer: Optimizer, task: Task) -> dict[str, Any]:
    """Make one run and return its numbers; see :class:`Surveyed` and ``MEASURES``."""
    name, place = task.problem.rsplit(" ", 1)
    problem = classic(name, DIMENSION, moved=place == "moved")
    found = make_run(problem, optimizer, budget=task.budget, seed=task.seed)
    points = problem.points[: task.budget]
    values = np.asarray(problem.noiseless(points), dtype=np.float64)
    numbers = behaviour(problem.share(points), values, 0.0, task.budget)
    generation = min(task.generation, len(values))
    first, following = values[:generation], values[generation : 3 * generation]
    logs = [float(np.log10(max(np.median(each), LEAST))) for each in (first, following if len(following) else first)]
    course = float(numbers.reshape(STAGES, len(TRAITS))[:, TRAITS.index("best")].mean())
    return {
        "measures": [*logs, course, float(found.fun)],
        "behaviour": numbers.tolist(),
        "clamped": float(on_bound(problem.share(found.x)).mean()),
        "evaluations": len(points),
        "points": hashlib.sha256(points.tobytes()).hexdigest(),
        "seconds": found.cpu_time,
    }


class _Row(dict[str, Any]):
    """What a run gave; its time, which no seed repeats, is an attribute."""

    seconds: float


def _answer(future: Future[Any]) -> _Row:
    """Wait for a run; raises BenchError where it failed, or where its process gave what is no record of a run."""
    try:
        answer = future.result()
    except DiedError as error:
        stuck = error.code == STILL_ASKING
        why = "went on asking for values after its budget was spent" if stuck else f"ended its process ({error})"
        raise BenchError(f"it {why}") from error
    except (*FAILURES, LostError) as error:
        raise BenchError(f"it failed: {printable(str(error), LONGEST)}") from error
    if isinstance(answer, dict) and "error" in answer:
        raise BenchError(printable(str(answer["error"]), LONGEST))
    try:
        row = _Row(
            measures=[float(each) for each in answer["measures"]],
            behaviour=[float(each) for each in answer["behaviour"]],
            clamped=float(answer["clamped"]), evaluations=int(answer["evaluations"]), points=str(answer["points"]),
        )  # fmt: skip
        row.seconds = float(answer["seconds"])
        if len(row["measures"]) != len(MEASURES) or len(row["behaviour"]) != STAGES * len(TRAITS):
            raise ValueError
    except (TypeError, ValueError, KeyError) as error:
        raise BenchError("its process gave an answer that is no record of a run") from error
    return row
