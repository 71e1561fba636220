"""Make the runs from which the biases of optimizers are judged: on functions and on noise, on every core."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from bench.check.conformance.single import PRINTED, single_run
from bench.check.conformance.subject import Subject, pack, unpack
from bench.check.problems import FUNCTIONS, classic, noise
from bench.contract.objective import scanner
from bench.contract.optimizer import Optimizer
from bench.contract.seeds import trial_seed
from bench.contract.typing import Floats
from bench.execution.job import MEMORY, TIMEOUT
from bench.execution.supervisor import row_of
from bench.helpers.errors import BenchError
from bench.helpers.parsing import Json
from bench.helpers.text import printable
from bench.sandbox.bubblewrap import Sandbox
from bench.sandbox.callers import Call, Callers
from bench.sandbox.messages import describe_error

GENERATIONS = 50  # of a run, at least: a bias of the moves needs time to show
FUNCTION_BUDGET = 10_000  # evaluations of a function, at least
NOISE_BUDGET = 1_000  # evaluations of noise, at least: without a field ``agents`` a generation counts as one evaluation

LONGEST = 4_000  # characters of a sentence on a failure

BOXES = {"[0, 1]": (0.0, 1.0), "[-1, 1]": (-1.0, 1.0)}
"""The boxes of the noise. The origin is a corner of the first, the box of the toolbox BIAS, and the centre of the
second, so that a method that is drawn to the origin shows it in one of them."""


@dataclass(frozen=True)
class RunSummary:
    """The record of one run; points are shares of the box, 0 at the lower and 1 at the upper bounds.

    Attributes:
        best: the lowest value.
        x: (d,) where it was found.
        first: (m, d) the points of the first generation, fewer where the run ended earlier.
        clamped: the share of all evaluated coordinates that lay exactly on a bound.
        course: a hash of all points in the order of their evaluation.
    """

    best: float
    x: Floats
    first: Floats
    clamped: float
    course: str


@dataclass(frozen=True)
class Runs:
    """The runs from which an optimizer is judged.

    Attributes:
        centred: by function, those with the optimum at the centre of the box; each has a seed of its own.
        moved: the same with the optimum moved by 10% of the box.
        noise: those on noise, by box; their seeds are adjacent numbers in each, and each has noise of its own.
    """

    centred: dict[str, list[RunSummary]]
    moved: dict[str, list[RunSummary]]
    noise: dict[str, list[RunSummary]]


@dataclass(frozen=True)
class CheckRun:
    """One run: its kind ("centred", "moved" or "noise"), its function or box, its number, and its least budget."""

    kind: str
    name: str
    run: int
    dimension: int
    budget: int
    seed: int


def make_runs(
    optimizers: Sequence[Optimizer | Subject],
    *,
    dimension: int = 7,
    runs: int = 10,
    noise_runs: int = 100,
    n_jobs: int = -1,
    seed: int = 0,
    sandbox: Sandbox | None = None,
    functions: Sequence[str] = tuple(FUNCTIONS),
    function_budget: int = FUNCTION_BUDGET,
    callers: type[Callers] = Callers,
) -> Iterator[Runs | BenchError]:
    """Yield the runs of each optimizer, or why it failed.

    All cores stay busy to the last run of the last optimizer. No run shares a process with another optimizer's.

    Args:
        optimizers: each with its parameters.
        dimension: the number of variables of every function.
        runs: of each function at each of two places, ``function_budget`` evaluations or 50 generations long.
        noise_runs: on noise in each of two boxes, at least 2, 1,000 evaluations or 50 generations long.
        n_jobs: runs made at a time; -1 takes every core. The numbers do not depend on it.
        seed: repeats every number.
        sandbox: in which all runs are made.
        functions: the names of those on which biases show.
        function_budget: of a run on a function, at least.
        callers: what makes the calls.
    """
    tasks = [
        CheckRun(kind, name, run, dimension, function_budget, seed)
        for name in functions
        for kind in ("centred", "moved")
        for run in range(runs)
    ]
    tasks += [CheckRun("noise", box, run, dimension, NOISE_BUDGET, seed) for box in BOXES for run in range(noise_runs)]
    limits: dict[str, object] = {"printed": PRINTED}
    if sandbox:
        limits |= {"seconds": TIMEOUT, "memory": MEMORY}
    packed = [_packed(optimizer) for optimizer in optimizers]
    failed: set[int] = set()  # whose other runs are given up

    def calls() -> Iterator[Call]:
        for group, each in enumerate(packed):
            for task in tasks if isinstance(each, bytes) else ():
                if group not in failed:
                    yield Call(group, make_run, (each, task), limits)

    with callers(n_jobs, ready, sandbox) as processes:
        groups = groupby(processes.answers(calls()), lambda answered: answered[0].group)
        for each in packed:
            if isinstance(each, BenchError):
                yield each
                continue
            group, answered = next(groups)
            made = _collected(tasks, (answer for _, answer in answered))
            if isinstance(made, BenchError):
                failed.add(group)
            yield made


def _packed(optimizer: Optimizer | Subject) -> bytes | BenchError:
    try:
        return pack(optimizer if isinstance(optimizer, Subject) else Subject.of(optimizer, {}, 0))
    except Exception as error:  # pickling runs a plug-in's code
        return BenchError(f"the optimizer cannot be sent to another process: {describe_error(error)}")


def _collected(tasks: list[CheckRun], answers: Iterable[object]) -> Runs | BenchError:
    """Return the runs of one optimizer, or the error of the first that failed."""
    made: dict[str, dict[str, list[RunSummary]]] = {"centred": {}, "moved": {}, "noise": {}}
    try:
        for task, answer in zip(tasks, answers, strict=True):
            made[task.kind].setdefault(task.name, []).append(summary(answer))
    except BenchError as error:
        return error
    return Runs(**made)


def ready() -> None:
    """Load this module and numba, for the scan of points, once for all forks: numba alone takes about a second."""
    scanner(FUNCTION_BUDGET, 1)


def make_run(packed: bytes, task: CheckRun) -> dict[str, object]:
    """Make one run; return the fields of its summary as JSON values, or the ``error`` that it ended with.

    Its seed depends on its problem and number alone.
    """
    optimizer = unpack(packed).fresh()
    if task.kind == "noise":
        label = f"noise {task.name}"
        problem = noise(BOXES[task.name], task.dimension, trial_seed(task.seed, label, "values", task.run))
        seed = trial_seed(task.seed, label, "structural bias", 0) + task.run
    else:
        label = f"{task.name} {task.kind}"
        problem = classic(task.name, task.dimension, moved=task.kind == "moved")
        seed = trial_seed(task.seed, label, "centre bias", task.run)
    generation = optimizer.minimum_budget
    try:
        result = single_run(problem, optimizer, max(task.budget, GENERATIONS * generation), seed)
    except BenchError as error:
        return {"error": str(error)}
    points = problem.points
    shares = problem.share(points)
    return {
        "best": result.fun,
        "x": problem.share(result.x).tolist(),
        "first": shares[:generation].tolist(),
        "clamped": float(on_bound(shares).mean()),
        "course": hashlib.sha256(points.tobytes()).hexdigest(),
    }


def on_bound(x: Floats) -> NDArray[np.bool_]:
    """Return flags of coordinates, given as shares of the box, that lie exactly on a bound, as a clip leaves them."""
    return np.asarray((x == 0) | (x == 1))


def summary(answer: Json) -> RunSummary:
    """Return the summary that a process answers; raises BenchError where the run failed, and for what is none."""
    if isinstance(answer, Exception):
        raise BenchError(f"the optimizer failed: {printable(str(row_of(answer)['error']), LONGEST)}")
    if isinstance(answer, dict) and "error" in answer:
        raise BenchError(printable(str(answer["error"]), LONGEST))
    try:
        x, first = (np.array(answer[name], np.float64) for name in ("x", "first"))
        made = RunSummary(float(answer["best"]), x, first, float(answer["clamped"]), str(answer["course"]))
        if (made.first.ndim, made.x.shape) != (2, made.first.shape[1:]):
            raise ValueError("no points of one dimension")
    except (TypeError, ValueError, KeyError) as error:
        raise BenchError("the process of the optimizer gave an answer that is no record of a run") from error
    return made
