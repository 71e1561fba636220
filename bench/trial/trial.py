"""One trial: run an optimizer on a problem, within a budget and from a seed, and return its result."""

import inspect
import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, isnan
from time import perf_counter, process_time
from typing import NamedTuple

if sys.platform == "win32":
    import psutil
else:
    import resource

import numpy as np

from bench.contract.objective import Logs, Objective, OnEvaluation, Trace
from bench.contract.optimizer import Optimizer
from bench.contract.problem import Problem
from bench.contract.seeds import streams
from bench.contract.typing import Floats
from bench.helpers.errors import BudgetExhausted, ProblemError
from bench.helpers.text import html_table, listed
from bench.trial import scoring
from bench.trial.columns import MEASURED, RESERVED, Row, packed

ROUNDING = 1e-9
"""By how much a value may differ, relative to itself, when its point is evaluated again."""

_SPREADS = 100.0  # times the differences seen among batches: a value near 0 is a difference of larger terms
_LONG = 1.0  # seconds of an evaluation, after which few others are made
_BATCHES = 2, 7, 32  # points; libraries of linear algebra treat small numbers of rows in different ways

UNASKED = "{} asks for no initial points, so it did not begin with those that are known ('initial')"
"""What is said of an optimizer that took none of the known points."""


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

    @property
    def columns(self) -> Row:
        """The columns of the trial's row that are known before it is made."""
        return {"problem": self.problem, "optimizer": self.optimizer, "trial": self.number, "seed": self.seed}


class Usage(NamedTuple):
    """How the optimizer used the objective, as in columns of a trial; ``unasked``: it took none of the known points."""

    calls: int
    largest_call: int
    outside_box: int
    failures: int
    unasked: bool


class Cost(NamedTuple):
    """The time and the memory that a search took, as in columns of a trial."""

    wall_s: float
    cpu_s: float
    objective_s: float
    memory_mb: float

    @property
    def overhead_s(self) -> float:
        """Wall seconds that the optimizer itself took."""
        return self.wall_s - self.objective_s


@dataclass(frozen=True, kw_only=True)
class Result:
    """The result of a trial: the best point, its value and the resources used.

    Attributes:
        x: (d,) the best point.
        fun: its value, +inf where no point counts.
        nfev: evaluations made.
        stop: why the search ended.
        trace: the best-so-far value over evaluations.
        metrics: the problem's domain metrics of ``x``.
        log: what the optimizer logged, by name (:meth:`bench.contract.objective.Objective.log`).
        seed: the seed that repeats the trial.
        usage: how the optimizer used the objective.
        cost: the time and the memory that the search took.
    """

    x: Floats
    fun: float
    nfev: int
    stop: str
    trace: Trace
    metrics: dict[str, float]
    seed: int
    usage: Usage
    cost: Cost
    log: Logs = field(default_factory=dict)

    @property
    def time(self) -> float:
        """Wall seconds of the whole search."""
        return self.cost.wall_s

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
            ("time", f"{self.cost.objective_s:.3f} s in the objective, {self.cost.overhead_s:.3f} s in the optimizer"),
            ("seed", self.seed),
        ]
        return html_table("Result of one run", rows)


def search(
    problem: Problem,
    optimizer: Optimizer,
    budget: int,
    seed: int,
    on_refusal: Callable[[int], None] | None = None,
    seconds: float | None = None,
    goal: float = -inf,
    on_evaluation: OnEvaluation | None = None,
) -> Result:
    """Run one optimizer once, as :func:`solve` does, in a process whose BLAS is limited to one thread already.

    See :class:`bench.contract.objective.Objective` for the arguments from ``on_refusal`` on. The result has no metrics:
    its best point is described by whoever keeps it, within a limit of time.

    Raises:
        ProblemError: when the problem raises at a point in the box.
        RuntimeError: when the optimizer returns without an evaluation.
        KeyboardInterrupt: on Ctrl-C; after an evaluation, its attribute ``found`` is the result so far.
        BaseException: whatever the optimizer raises.
    """
    start_stream, search_stream = streams(seed)
    objective = scoring.objective(problem, budget, start_stream, on_refusal, seconds, goal, on_evaluation)
    memory, wall, cpu = peak_memory(), perf_counter(), process_time()
    returned = interrupt = None
    try:
        returned = optimizer.minimize(objective, search_stream)
    except BudgetExhausted:
        pass
    except KeyboardInterrupt as error:
        if objective.best_point is None:
            raise
        interrupt = error
        objective.stop("interrupted")
    except (Exception, SystemExit):
        if objective.raised is None:
            raise
    wall, cpu = perf_counter() - wall, process_time() - cpu
    memory = max(0.0, peak_memory() - memory)  # Linux counts pages core by core, and may report less than it did before
    found = result(objective, seed, Cost(wall, cpu, objective.objective_s, memory), returned)
    if interrupt is not None:
        vars(interrupt)["found"] = found
        raise interrupt
    return found


def peak_memory() -> float:
    """Return the most megabytes that this process has had in memory, by itself and not by its parent."""
    if sys.platform == "win32":
        return float(psutil.Process().memory_info().peak_wset) / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6


def result(objective: Objective, seed: int, cost: Cost, returned: object = None) -> Result:
    """Return the result of a search that has ended, from its objective and its cost.

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
        hint = f"; it was stopped: {objective.stop_reason}" if objective.stop_reason else hint
        raise RuntimeError(f"the optimizer returned without a single evaluation{hint}")
    stop = "budget" if objective.nfev == objective.budget else objective.stop_reason
    return Result(
        x=objective.best_point, fun=objective.fun, nfev=objective.nfev, stop="undeclared" if stop is None else stop,
        trace=objective.trace, metrics={}, seed=seed, log=objective.logged,
        usage=Usage(**{name: getattr(objective, name) for name in Usage._fields}), cost=cost,
    )  # fmt: skip


def doubt(result: Result, problem: Problem) -> str:
    """Return how the value of a result's best point differs when that is evaluated again, alone; "" where it agrees.

    A value may differ by 1e-9 of itself, or by 100 times the differences that are seen among batches of the point:
    some libraries round a point alone otherwise than in a batch. One evaluation is made where the value agrees, and
    some more where it does not.

    Raises:
        ProblemError: when the problem raises there.
    """
    if not ((result.x >= problem.lower) & (result.x <= problem.upper)).all():
        return ""  # no point of the trial is in the box, so it has no value

    def values(size: int) -> Floats:
        return np.asarray(problem.evaluate(np.tile(result.x, (size, 1))), np.float64)

    try:
        began = perf_counter()
        value = float(values(1)[0])
        batches = _BATCHES if perf_counter() - began < _LONG else _BATCHES[:1]
        value = inf if isnan(value) else value
        rounding = ROUNDING * abs(value) if isfinite(value) else 0.0
        if value == result.fun or abs(value - result.fun) <= rounding:
            return ""
        spread = max(float(np.ptp([value, *values(size)])) for size in batches) if isfinite(value) else 0.0
        noise = max(abs(value - float(values(1)[0])) for _ in batches)
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


def as_row(result: Result, variables: tuple[str, ...]) -> Row:
    """Return the row of a finished trial from its result; see :func:`finished`."""
    return finished(measured(result), variables, result.x, numbers(result.metrics), result.trace, result.log)


def measured(result: Result) -> Row:
    """Return those columns of a result's row that are single values."""
    values = vars(result) | result.usage._asdict() | result.cost._asdict()
    return {column.name: values[column.name] for column in MEASURED}


def finished(
    measured: Row,
    variables: tuple[str, ...],
    x: Floats,
    metrics: Mapping[str, float],
    trace: Trace,
    log: Logs | None = None,
) -> Row:
    """Return the row of a finished trial as the store keeps it.

    Raises:
        ValueError: when variables or domain metrics cannot be columns: variable names are missing or repeated, a metric
            has the name of a column of the frame or is no number.
    """
    if len(set(variables)) != len(x):
        raise ValueError(f"the problem names {len(set(variables))} different variables for {len(x)} dimensions")
    if reserved := sorted(name for name in metrics if name in RESERVED or name.startswith("x_")):
        raise ValueError(f"the problem's describe() uses a name of the tidy frame: {reserved[0]!r}")
    point = dict(zip(variables, x.tolist(), strict=True))
    logged = {"log": json.dumps(log).encode()} if log else {}
    return packed({"status": "ok", **measured, **logged, "x": point, "metrics": metrics, "trace": trace})


def numbers(metrics: Mapping[str, float]) -> dict[str, float]:
    """Return metrics, as a problem describes them, as floats by text; raises ValueError or TypeError for no number."""
    return {str(name): float(value) for name, value in dict(metrics).items()}
