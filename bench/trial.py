"""One trial: run an optimizer on a problem, within a budget and from a seed, and return its result."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, isnan
from time import perf_counter, process_time
from typing import Any

import numpy as np

from bench import scoring
from bench.errors import ProblemError
from bench.helpers.text import html_table, listed
from bench.objective import BudgetExhausted, Objective, Trace
from bench.optimizer import Optimizer
from bench.problem import Problem
from bench.seeds import streams
from bench.typing import Floats

FRAME_COLUMNS = (
    "study", "problem", "optimizer", "trial", "seed", "status", "fun", "nfev", "wall_s", "cpu_s", "objective_s",
    "stop", "outside_box", "error",
)  # fmt: skip
"""The tidy frame's own columns; one ``x_<variable>`` for each variable and the domain metrics follow."""

PRECISION = "precision"
"""The column of the tidy frame that is computed when it is read: the objective value less the known optimum."""

FEATURES = ("suite", "function", "dimension", "instance", "group")
"""The columns of the tidy frame that say of which kind a problem is, as it loads where the frame is read."""

ROUNDING = 1e-9
"""By how much a value may differ, relative to itself, when its point is evaluated again."""

_SPREADS = 100.0  # times the differences seen among batches: a value near 0 is a difference of larger terms
_BATCHES = 2, 7, 32  # points; libraries of linear algebra treat small numbers of rows in different ways

Row = dict[str, Any]
"""A trial's columns by name, as :func:`as_row` makes them and :mod:`bench.storage.store` keeps them."""


@dataclass(frozen=True, slots=True)
class Trial:
    """A planned run: a cell of the study (problem label, optimizer label), its number from 0, and its seed.

    ``again`` has it made in a process that has made no other trial.
    """

    problem: str
    optimizer: str
    number: int
    seed: int
    again: bool = field(default=False, compare=False)

    @property
    def key(self) -> tuple[str, str, int]:
        """The identity of the trial within its study."""
        return self.problem, self.optimizer, self.number


@dataclass(frozen=True)
class Result:
    """The result of a trial: the best point, its value and the resources used.

    Attributes:
        x: (d,) the best point.
        fun: its objective value.
        nfev: evaluations made.
        trace: the best-so-far value over evaluations.
        time: wall seconds of the whole search.
        cpu_time: processor seconds of the same.
        objective_time: wall seconds inside the problem's evaluate; the optimizer's overhead is ``time`` less this.
        stop: ``"budget"``, or the reason the optimizer declared, or ``"undeclared"`` when it declared none.
        outside_box: evaluations spent outside the box.
        metrics: the problem's domain metrics of ``x``.
        seed: the seed that repeats the trial.
    """

    x: Floats
    fun: float
    nfev: int
    trace: Trace
    time: float
    cpu_time: float
    objective_time: float
    stop: str
    outside_box: int
    metrics: dict[str, float]
    seed: int

    @property
    def overhead_time(self) -> float:
        """Wall seconds that the optimizer itself took."""
        return self.time - self.objective_time

    def __repr__(self) -> str:
        """Return the result in a few lines: the trace and a long point are shortened."""
        point = listed([f"{coordinate:.6g}" for coordinate in self.x], 10)
        metrics = "".join(f", {name}={value:.6g}" for name, value in self.metrics.items())
        return (
            f"Result(fun={self.fun!r}, x=[{point}]{metrics},\n"
            f"       nfev={self.nfev}, stop={self.stop!r}, improvements={len(self.trace.values)}, "
            f"time={self.time:.3g}, seed={self.seed})"
        )

    def _repr_html_(self) -> str:
        """Return the result as a table, for a notebook."""
        rows = [
            ("best value", f"{self.fun:.10g}"),
            ("best point", listed([f"{coordinate:.6g}" for coordinate in self.x], 10)),
            *((name, f"{value:.6g}") for name, value in self.metrics.items()),
            ("evaluations", f"{self.nfev:,} (stopped by: {self.stop})"),
            ("time", f"{self.objective_time:.3f} s in the objective, {self.overhead_time:.3f} s in the optimizer"),
            ("seed", self.seed),
        ]
        return html_table("Result of one run", rows)


def search(
    problem: Problem, optimizer: Optimizer, budget: int, seed: int, on_refusal: Callable[[int], None] | None = None
) -> Result:
    """Run one optimizer once, as :func:`solve` does, in a process whose BLAS is limited to one thread already.

    See :class:`bench.objective.Objective` for ``on_refusal``. The result has no metrics: its best point is described by
    whoever keeps it, within a limit of time.

    Raises:
        ProblemError: when the problem raises at a point in the box.
        RuntimeError: when the optimizer returns without an evaluation.
        BaseException: whatever the optimizer raises.
    """
    start_stream, search_stream = streams(seed)
    objective = scoring.objective(problem, budget, start_stream, on_refusal)
    wall, cpu = perf_counter(), process_time()
    try:
        returned = run(optimizer, objective, search_stream)
    except (Exception, SystemExit):
        if objective.raised is None:
            raise
        returned = None
    wall, cpu = perf_counter() - wall, process_time() - cpu
    return result(objective, seed, wall, cpu, returned)


def run(optimizer: Optimizer, objective: Any, rng: np.random.Generator) -> object:
    """Let an optimizer minimise until it returns or its budget ends; return what it returned."""
    try:
        return optimizer.minimize(objective, rng)
    except BudgetExhausted:
        return None


def result(objective: Objective, seed: int, wall: float, cpu: float, returned: object = None) -> Result:
    """Return the result of a search that has ended, from its objective and its wall and processor seconds.

    Its best point is not described: its metrics are empty.

    Raises:
        ProblemError: when the problem raised.
        RuntimeError: without an evaluation; what the optimizer ``returned`` may explain it.
    """
    if objective.raised is not None:
        raise ProblemError(objective.raised) from objective.raised
    if objective.best_point is None:
        lazy = inspect.isgenerator(returned) or inspect.isawaitable(returned) or inspect.isasyncgen(returned)
        hint = "; its minimize holds a yield or is async, so none of it has run" if lazy else ""
        raise RuntimeError(f"the optimizer returned without a single evaluation{hint}")
    stop = "budget" if objective.remaining == 0 else objective.stop_reason
    return Result(
        x=objective.best_point,
        fun=objective.best_value,
        nfev=objective.evaluations,
        trace=objective.trace,
        time=wall,
        cpu_time=cpu,
        objective_time=objective.seconds,
        stop="undeclared" if stop is None else stop,
        outside_box=objective.outside_box,
        metrics={},
        seed=seed,
    )


def doubt(result: Result, problem: Problem) -> str:
    """Return how the value of a result's best point differs when that is evaluated again, alone; "" where it agrees.

    A value may differ by 1e-9 of itself, or by 100 times the differences that are seen among batches of the point:
    some libraries round a point alone otherwise than in a batch.

    Raises:
        ProblemError: when the problem raises there.
    """
    if not ((result.x >= problem.lower) & (result.x <= problem.upper)).all():
        return ""  # no point of the trial is in the box, so it has no value

    def values(size: int) -> Floats:
        return np.asarray(problem.evaluate(np.tile(result.x, (size, 1))), np.float64)

    try:
        value = float(values(1)[0])
        value = inf if isnan(value) else value
        rounding = ROUNDING * abs(value) if isfinite(value) else 0.0
        if value == result.fun or abs(value - result.fun) <= rounding:
            return ""
        spread = max(float(np.ptp([value, *values(size)])) for size in _BATCHES) if isfinite(value) else 0.0
        noise = max(abs(value - float(values(1)[0])) for _ in _BATCHES)
    except Exception as error:  # a plug-in may raise anything
        raise ProblemError(error) from error
    if noise > rounding:
        return (
            f"problem {problem.name!r} has noise that it does not declare: the value {value!r} of the best point "
            f"differs by {noise:.2g} when the point is evaluated again; set noisy = True, and return true values from "
            "noiseless"
        )
    if isfinite(value) and abs(value - result.fun) <= rounding + _SPREADS * spread:
        return ""
    return (
        f"the best value is {result.fun!r}, and its point has {value!r} when it is evaluated again, alone; a value may "
        "depend on nothing but the point"
    )


def as_row(result: Result, variables: tuple[str, ...]) -> dict[str, Any]:
    """Return the result as the columns of its store row (see bench.storage.store).

    Raises:
        ValueError: when variables or domain metrics cannot be columns: variable names are missing or repeated, a metric
            has the name of a column of the frame or is no number.
    """
    if len(set(variables)) != len(result.x):
        raise ValueError(f"the problem names {len(set(variables))} different variables for {len(result.x)} dimensions")
    metrics = numbers(result.metrics)
    reserved = sorted(name for name in metrics if name in (*FRAME_COLUMNS, PRECISION) or name.startswith("x_"))
    if reserved:
        raise ValueError(f"the problem's describe() uses a name of the tidy frame: {reserved[0]!r}")
    return {
        "status": "ok",
        **measured(result),
        "x": dict(zip(variables, result.x.tolist(), strict=True)),
        "metrics": metrics,
        "trace": result.trace,
    }


def measured(result: Result) -> dict[str, Any]:
    """Return those columns of a result's row that are single values."""
    return {
        "fun": result.fun,
        "nfev": result.nfev,
        "wall_s": result.time,
        "cpu_s": result.cpu_time,
        "objective_s": result.objective_time,
        "stop": result.stop,
        "outside_box": result.outside_box,
    }


def numbers(metrics: Mapping[Any, Any]) -> dict[str, float]:
    """Return metrics, as a problem describes them, as floats by text; raises ValueError or TypeError for no number."""
    return {str(name): float(value) for name, value in dict(metrics).items()}
