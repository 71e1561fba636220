"""Run the implementations of an atlas, and look for parameters that change nothing.

Every run is made by :mod:`bench.execution.safe_runs`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import cache, partial
from itertools import count
from typing import Any

import numpy as np

from bench.analysis.similarity import LEAST, STAGES, TRAITS, behaviour
from bench.atlas.table import Implementation, Method
from bench.check.idle import alternatives
from bench.check.problems import FUNCTIONS, classic
from bench.check.runs import on_bound
from bench.errors import BenchError
from bench.execution.safe_runs import LONGEST, Begin, found, in_order, safe_run, safe_runs
from bench.helpers.console import OnStep
from bench.helpers.text import printable
from bench.optimizer import Optimizer
from bench.plugins.loading import load_optimizer
from bench.sandbox.messages import describe_error
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


@dataclass(frozen=True)
class AtlasRun:
    """One run: its problem, budget, seed, and the evaluations of a generation."""

    problem: str
    budget: int
    seed: int
    generation: int


@dataclass(frozen=True)
class Surveyed:
    """The measurements of an implementation.

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
    measures: Mapping[str, Floats] = field(default_factory=dict)
    behaviours: Mapping[str, Floats] = field(default_factory=dict)
    clamped: float = float("nan")
    evaluations: float = float("nan")
    repeatable: bool = True
    dead: Mapping[str, str] = field(default_factory=dict)
    microseconds: float = float("nan")
    failed: str = ""


def survey(
    methods: Sequence[Method],
    *,
    trials: int,
    budget: int,
    seed: int = 0,
    jobs: int = -1,
    on_progress: OnStep = lambda *_: None,
) -> list[Surveyed]:
    """Run all implementations and return what was seen of each, in order.

    A trial's seed depends on its implementation, problem and number alone. An implementation that fails in any run, or
    whose library is missing, is returned with the reason.

    Args:
        methods: the methods.
        trials: of each implementation on each of ``PROBLEMS``.
        budget: evaluations of a trial.
        seed: repeats every number but times.
        jobs: runs made at a time; -1 takes every core. The numbers do not depend on it.
        on_progress: called with the current implementation, the runs done and all runs.
    """
    with safe_runs(jobs, ready) as begin:
        begun = [
            _begin(begin, entry, method, trials, budget, seed) for method in methods for entry in method.implementations
        ]
        total, done = sum(len(runs) for _, runs, _ in begun), count()
        return [_collect(*calls, lambda key: on_progress(key, next(done), total)) for calls in begun]


def _begin(
    begin: Begin, implementation: Implementation, method: Method, trials: int, budget: int, seed: int
) -> tuple[Surveyed, list[Future[Any]], dict[str, Future[Any]]]:
    """Begin the calls of an implementation and return what is known of it before they end.

    The calls are its runs, problem by problem, at last the first one of ``PROBES[0]`` again; and by parameter the
    probe of its other values.
    """
    try:
        optimizer = load_optimizer(implementation.name, **implementation.options)
        optimizer.check_budget(budget, implementation.label)
    except BenchError as error:
        return Surveyed(implementation, failed=printable(str(error), LONGEST)), [], {}
    except Exception as error:  # a plug-in may raise anything
        return Surveyed(implementation, failed=f"it cannot be loaded: {describe_error(error)}"), [], {}
    tasks = [
        AtlasRun(problem, budget, trial_seed(seed, problem, implementation.key, trial), method.generation)
        for problem in PROBLEMS
        for trial in range(trials)
    ]
    firsts = [tasks[PROBLEMS.index(problem) * trials] for problem in PROBES]
    call = partial(begin, implementation.key, seconds=TIMEOUT)
    runs = [call(run, implementation.name, implementation.options, task) for task in [*tasks, firsts[0]]]
    probes = {
        name: call(probe, implementation.name, implementation.options, name, values, firsts)
        for name, values in alternatives(optimizer, method.technical).items()
    }
    return Surveyed(implementation, optimizer.code), runs, probes


def _collect(
    surveyed: Surveyed, runs: Sequence[Future[Any]], probes: Mapping[str, Future[Any]], on_made: Callable[[str], None]
) -> Surveyed:
    """Wait for the calls of an implementation; the first run that fails ends the others."""
    if surveyed.failed:
        return surveyed
    records = []
    try:
        for record in in_order(runs, dict):
            on_made(surveyed.implementation.key)
            records.append(record)
    except BenchError as error:
        for probed in probes.values():
            probed.cancel()
        return replace(surveyed, failed=str(error))
    again, shape = records.pop(), (len(PROBLEMS), len(records) // len(PROBLEMS), -1)
    repeatable = again["points"] == records[PROBLEMS.index(PROBES[0]) * shape[1]]["points"]
    numbers: dict[str, Floats] = {
        name: np.array([record[name] for record in records], dtype=np.float64).reshape(shape)
        for name in ("measures", "behaviour", "clamped", "evaluations", "cpu_s")
    }
    tried = {name: _without_effect(probed) for name, probed in probes.items()}
    return replace(
        surveyed,
        measures=dict(zip(PROBLEMS, numbers["measures"], strict=True)),
        behaviours=dict(zip(PROBLEMS, numbers["behaviour"], strict=True)),
        clamped=float(numbers["clamped"].mean()),
        evaluations=float(np.median(numbers["evaluations"])),
        repeatable=repeatable,
        dead={name: values for name, values in tried.items() if values and repeatable},
        microseconds=float(np.median(1e6 * numbers["cpu_s"] / numbers["evaluations"])),
    )


def _without_effect(probed: Future[Any]) -> str:
    """Return the values that a probe tried, "" where one had an effect or ended its process."""
    try:
        return found(probed, lambda record: printable(str(record["tried"]), LONGEST))
    except BenchError:
        return ""


def ready() -> None:
    """Load this module."""


def run(name: str, options: Mapping[str, Any], task: AtlasRun) -> dict[str, Any]:
    """Make one run of an optimizer; return its numbers."""
    return measure(load_optimizer(name, **options), task)


def probe(
    name: str, options: Mapping[str, Any], parameter: str, values: list[Any], tasks: list[AtlasRun]
) -> dict[str, str]:
    """Make runs that differ in one parameter; return the values ``tried`` as text, "" where one had an effect.

    A value that the library refuses, or fails with, shows nothing and counts as not tried.
    """

    @cache
    def points(task: AtlasRun) -> str:
        return str(measure(load_optimizer(name, **options), task)["points"])

    tried = []
    for value in values:
        try:
            changed = load_optimizer(name, **{**options, parameter: value})
            if any(measure(changed, task)["points"] != points(task) for task in tasks):
                return {"tried": ""}
        except (Exception, SystemExit):  # a plug-in may raise anything
            continue
        tried.append(repr(value))
    return {"tried": ", ".join(tried)}


def measure(optimizer: Optimizer, task: AtlasRun) -> dict[str, Any]:
    """Make one run and return its numbers; see :class:`Surveyed` and ``MEASURES``."""
    name, place = task.problem.rsplit(" ", 1)
    problem = classic(name, DIMENSION, moved=place == "moved")
    result = safe_run(problem, optimizer, budget=task.budget, seed=task.seed)
    points = problem.points[: task.budget]
    values = np.asarray(problem.noiseless(points), dtype=np.float64)
    numbers = behaviour(problem.share(points), values, 0.0, task.budget)
    generation = min(task.generation, len(values))
    first, following = values[:generation], values[generation : 3 * generation]
    medians = np.median(first), np.median(following if len(following) else first)
    logs = [float(np.log10(max(median, LEAST))) for median in medians]
    course = float(numbers.reshape(STAGES, len(TRAITS))[:, TRAITS.index("best")].mean())
    return {
        "measures": np.array([*logs, course, float(result.fun)]),
        "behaviour": numbers,
        "clamped": float(on_bound(problem.share(result.x)).mean()),
        "evaluations": len(points),
        "points": hashlib.sha256(points.tobytes()).hexdigest(),
        "cpu_s": result.cpu_s,
    }
