"""The objective, all that an optimizer sees of a problem: a counted and clocked function with a hard budget."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite
from threading import Lock
from time import perf_counter
from typing import Any

import numpy as np
from numpy import ndarray
from numpy.typing import ArrayLike, NDArray

from bench.contract.numbers import require_whole
from bench.contract.problem import Problem
from bench.contract.typing import Flags, Floats
from bench.helpers.compiled import compiled
from bench.helpers.errors import BudgetExhausted, StopRun
from bench.helpers.text import printable, said

_FLOAT64 = np.dtype(np.float64)
_LONGEST_REASON = 200  # characters
OUT_OF_TIME, ON_TARGET = "time", "target"
"""The reasons that a trial has ended before its budget: at its limit of time, or as its value was good enough."""

IMPROVEMENT = 16  # bytes: its evaluation as int64, its value as float64
_ILLEGAL = -inf  # a value that no problem may return
_SIGNATURE = "Tuple((float64, int64))(float64[:, ::1], float64[::1], float64[:, ::1])"
_MANY = 30  # points of a call, which numpy looks at in about the time of as many evaluations
_WORTH_COMPILING = 10_000  # coordinates of points, with which an interpreter is busy for a few milliseconds


OnEvaluation = Callable[[int, Floats, float, float], object]
"""Is called after each evaluation with its number from 1, the (d,) point, the value recorded and the lowest so far."""


LOGGED = 200
"""Values that a trial keeps of each name that an optimizer logs, at most; and names, a tenth of that."""

Logs = dict[str, list[tuple[int, float | None]]]
"""What an optimizer has logged: by name, evaluations (increasing) and values, None for one that is not finite."""


class Log:
    """Numbers that an optimizer keeps of its search, thinned evenly: after 200 of a name, every second one goes."""

    def __init__(self) -> None:
        self.values: Logs = {}
        self._steps: dict[str, tuple[int, int]] = {}  # by name: every how many-th is kept, and how many came

    def add(self, evaluations: int, name: str, value: float) -> None:
        """Keep a value, unless it is thinned out; raises ValueError for a name too many, TypeError for no number."""
        if name not in self.values:
            if len(self.values) >= LOGGED // 10:
                raise ValueError(f"an optimizer may log {LOGGED // 10} names, and {name!r} is one more")
            self.values[name], self._steps[name] = [], (1, 0)
        number, kept = float(value), self.values[name]
        step, came = self._steps[name]
        if came % step == 0:
            if kept and kept[-1][0] == evaluations:
                kept.pop()
            kept.append((evaluations, number if isfinite(number) else None))
        if len(kept) == LOGGED:
            del kept[1::2]
            step *= 2
        self._steps[name] = step, came + 1


@dataclass(frozen=True)
class Trace:
    """The anytime record of a trial: improvements only.

    Attributes:
        evaluations: (m,) int64, the evaluation (counted from 1) at which each improvement was found, increasing.
        values: (m,) float64, the best-so-far objective value from that evaluation on, decreasing.
    """

    evaluations: NDArray[np.int64]
    values: Floats

    def at(self, evaluations: ArrayLike) -> Floats:
        """Return the best-so-far value after each of the given evaluation counts, +inf before the first."""
        position = np.searchsorted(self.evaluations, np.asarray(evaluations), side="right")
        return np.concatenate(([np.inf], self.values))[position]

    def packed(self) -> bytes:
        """Return the trace as bytes: m little-endian int64 evaluation counts, then m float64 best-so-far values."""
        return self.evaluations.astype("<i8").tobytes() + self.values.astype("<f8").tobytes()

    @classmethod
    def unpacked(cls, packed: bytes | memoryview) -> "Trace":
        """Return the trace that :meth:`packed` packed; its arrays share the memory of the bytes.

        Raises:
            ValueError: when the number of bytes fits no trace.
        """
        if len(packed) % IMPROVEMENT:
            raise ValueError(f"{len(packed)} bytes are no trace")
        half = len(packed) // 2
        return cls(np.frombuffer(packed[:half], dtype="<i8"), np.frombuffer(packed[half:], dtype="<f8"))


class Objective:
    """The function that an optimizer minimises, and all that it may know of the problem.

    ``objective(x)`` takes (n, d) points and returns (n,) values, or one (d,) point and returns a float. Every row
    counts as one evaluation; a row outside the box or not finite is counted too, and its value is +inf, so
    leaving the box gains nothing. A NaN value counts as +inf. No row past the budget is evaluated.

    The points are read once. That private copy is checked, evaluated and kept, so neither an optimizer that changes its
    array during the call nor a problem that writes into its argument can make them differ. Threads take turns.

    Attributes:
        lower: (d,) the lower end of the box.
        upper: (d,) its upper end.
        x0: (k, d) points that are known before the search, with which :meth:`initial` begins; k is 0 without any.
        integer: (d,) bool, the variables that are whole numbers. The harness rounds them; an optimizer may use it.
        failures: evaluations that failed and count with the value +inf, where the study goes on.
        raised: the first exception that the problem raised at points in the box, None without. It loses the trial, even
            if the optimizer catches it.

    Args:
        problem: what is minimised.
        budget: the number of evaluations allowed, at least 1.
        rng: the trial's stream for initial points, independent of the optimizer's own.
        on_refusal: called whenever points are refused because the budget is spent, with the number of refusals so far.
        seconds: wall seconds after the first call from which on points are refused, too; None for no limit. A call that
            has begun is finished.
        goal: the value that is good enough: once a point has it, points are refused; -inf for none.
        on_evaluation: called for every evaluation, after the call of the objective that made it.
    """

    def __init__(
        self,
        problem: Problem,
        budget: int,
        rng: np.random.Generator,
        on_refusal: Callable[[int], None] | None = None,
        seconds: float | None = None,
        goal: float = -inf,
        on_evaluation: OnEvaluation | None = None,
    ) -> None:
        require_whole("the budget of evaluations", budget, 1)
        self.lower: Floats = problem.lower.copy()
        self.upper: Floats = problem.upper.copy()
        self.integer = integer_flags(problem)
        known = problem.initial_points
        self.x0: Floats = np.empty((0, self.dimension)) if known is None else np.array(known, dtype=np.float64)
        self._begun = 0  # how many of them were handed out
        self.x0.flags.writeable = False
        self.lower.flags.writeable = self.upper.flags.writeable = self.integer.flags.writeable = False
        self.calls = self.largest_call = self.outside_box = self.failures = 0
        self.objective_s = 0.0  # spent inside the problem's evaluate
        self.fun = np.inf  # the lowest value so far
        self.best_point: Floats | None = None
        self._budget = self._limit = budget  # the limit is what it may spend in the end
        self._nfev = 0
        self._stop_reason: str | None = None
        self.raised: BaseException | None = None  # by the problem's own code, at points in the box
        self._problem = problem
        self._compute: Callable[[Floats], ArrayLike] = problem.evaluate  # the values to record of (n, d) points
        self._rng = rng
        self._improved_at: list[int] = []
        self._improved_to: list[float] = []
        self._refusals = 0
        self._on_refusal = on_refusal
        self._log = Log()
        self._seconds, self._until = seconds, inf
        self._goal, self._on_evaluation = goal, on_evaluation
        self._scan = scanner(budget, self.dimension) if "numba" in sys.modules else self._scan_first
        self._single = self.lower.shape  # of one point
        self._box = np.array([self.lower, self.upper], dtype=np.float64)
        self._lock = Lock()  # threads of an optimizer must not exceed the budget together

    @property
    def dimension(self) -> int:
        """The number of search variables d."""
        return len(self.lower)

    @property
    def budget(self) -> int:
        """The number of evaluations allowed."""
        return self._budget

    @property
    def nfev(self) -> int:
        """The number of evaluations made."""
        return self._nfev

    @property
    def stop_reason(self) -> str | None:
        """The reason that the optimizer declared for ending before its budget, if any."""
        return self._stop_reason

    @property
    def remaining(self) -> int:
        """The number of evaluations left."""
        return self._limit - self._nfev

    def repair(self, x: Floats) -> Floats:
        """Return the (n, d) feasible points nearest to ``x`` by the problem's rule; costs no evaluation."""
        return repaired(self._problem, x)

    def initial(self, n: int) -> Floats:
        """Return (n, d) points, uniform in the box and then repaired, independent in every trial.

        Known points (:attr:`x0`) stand in the place of the first ones; each is handed out once, as it is. Of an
        integer variable, all whole numbers between its bounds are equally probable.
        """
        shares = self._rng.random((n, self.dimension))
        points = self.lower + (self.upper - self.lower) * shares
        if self.integer.any():
            points = np.where(self.integer, np.floor(self.lower + (self.upper - self.lower + 1) * shares), points)
        points = self.repair(points)
        if self._begun < len(self.x0):
            known = self.handed_out(n)
            points[: len(known)] = known
        return points

    def start_point(self) -> Floats:
        """Return a (d,) point to start from: one of :meth:`initial`, or the best of known points, which it evaluates.

        Known points are evaluated once: later calls return points of :meth:`initial`.
        """
        known = self.handed_out(len(self.x0))
        if not len(known):
            return np.asarray(self.initial(1)[0])
        return np.asarray(known[int(np.argmin(self(known)))])

    def handed_out(self, n: int) -> Floats:
        """Return up to ``n`` of the known points that were not handed out before."""
        known = self.x0[self._begun : self._begun + n].copy()
        self._begun += len(known)
        return known

    @property
    def unasked(self) -> bool:
        """Whether there are known points, and the optimizer has taken none."""
        return bool(len(self.x0)) and not self._begun

    def log(self, **values: float) -> None:
        """Keep numbers of the search, such as ``objective.log(step=0.3)``, with the evaluations made so far.

        They cost no evaluation, are stored with the trial, and reports draw them next to the convergence. Of each of at
        most 20 names, 200 values are kept, evenly thinned.

        Raises:
            ValueError: for a name too many.
            TypeError: for a value that is not a number.
        """
        for name, value in values.items():
            self._log.add(self._nfev, name, value)

    @property
    def logged(self) -> Logs:
        """The log so far."""
        return self._log.values

    def stop(self, reason: str) -> None:
        """Declare that the optimizer ends before its budget by a criterion of its own, such as ``"tolfun"``.

        A study refuses the reason ``"budget"`` of a trial that has evaluations left; ``"time"`` and ``"target"`` are
        the harness's, too.
        """
        declared = printable(" ".join(said(reason).split()), _LONGEST_REASON)
        if self._stop_reason not in (OUT_OF_TIME, ON_TARGET):
            self._stop_reason = f"{declared} (declared)" if declared in (OUT_OF_TIME, ON_TARGET) else declared

    def __call__(self, x: ArrayLike) -> Any:
        """Return the (n,) values of (n, d) points, or the float of one (d,) point.

        Raises:
            BudgetExhausted: when the budget ends before the last row; the rows before are evaluated and kept.
            ValueError: for points of another shape.
            TypeError: for points that are not real numbers.
        """
        points = x.copy() if type(x) is ndarray and x.dtype is _FLOAT64 else floats(x, "points")
        single = points.shape == self._single
        if not single and points.shape[1:] != self._single:
            d = self.dimension
            raise ValueError(f"expected points of shape (n, {d}) or ({d},), got {points.shape}")
        rows = points[None] if single else points
        with self._lock:
            remaining = self._limit - self._nfev if self._seconds is None else self._in_time()
            allowed = rows if len(rows) <= remaining else rows[:remaining]
            try:
                values = self._evaluate(allowed)
                if self._on_evaluation is not None and len(allowed):
                    self._report(allowed, self._on_evaluation)
            except StopRun as stopped:
                self.stop(str(stopped) or type(stopped).__name__)
                self._limit = self._nfev
                raise
            except (Exception, SystemExit) as error:
                self._note(error, allowed)
                raise
        if allowed is not rows:
            self._refusals += 1
            if self._on_refusal is not None:
                self._on_refusal(self._refusals)
            raise BudgetExhausted
        return values.item() if single else values

    def _in_time(self) -> int:
        """Return the evaluations left within the limit of time, which the first call sets."""
        now = perf_counter()
        if self._until == inf:
            self._until = now + (self._seconds or 0.0)
        if now < self._until or not self.remaining:
            return self.remaining
        self._stop_reason = OUT_OF_TIME
        return 0

    def _report(self, points: Floats, on_evaluation: OnEvaluation) -> None:
        """Report the evaluations of a call, one after the other."""
        numbers = np.arange(self._nfev - len(points) + 1, self._nfev + 1)
        for number, point, value, lowest in zip(
            numbers.tolist(), points, self._recorded.tolist(), self.trace.at(numbers).tolist(), strict=True
        ):
            on_evaluation(number, point.copy(), value, lowest)

    def _note(self, error: BaseException, points: Floats) -> None:
        """Note the first exception of the problem's code; one at a point outside the box is the optimizer's fault."""
        if self.raised is None and bool(((points >= self.lower) & (points <= self.upper)).all()):
            self.raised = error

    def _evaluate(self, rows: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points, recorded and counted."""
        n = len(rows)
        if not n:
            return np.empty(0)
        points = rows.copy()  # the problem may write into it, or keep it
        began = perf_counter()
        returned = self._compute(points)
        self.objective_s += perf_counter() - began
        if type(returned) is ndarray and returned.dtype is _FLOAT64 and returned.shape == (n,):  # as nearly always
            values = returned.copy()
        else:
            values = as_values(self._problem, returned, n)
        self._recorded = values
        lowest, outside = self._scan(rows, values, self._box)
        if lowest == _ILLEGAL:
            raise minus_infinity(self._problem)
        self.outside_box += outside
        if lowest < self.fun:
            best_before = np.minimum.accumulate(np.append(self.fun, values[:-1]))
            better = np.flatnonzero(values < best_before)
            self._improved_at += (better + (self._nfev + 1)).tolist()
            self._improved_to += values[better].tolist()
            self.fun = self._improved_to[-1]
            self.best_point = rows[better[-1]].copy()
            if self.fun <= self._goal:
                self._stop_reason, self._limit = ON_TARGET, self._nfev + n
        elif self.best_point is None:
            self.best_point = rows[0].copy()
        self._nfev += n
        self.calls += 1
        if n > self.largest_call:
            self.largest_call = n
        return values

    def _scan_first(self, points: Floats, values: Floats, box: Floats) -> tuple[float, int]:
        """Scan large batches by numpy, until the first call with few points, for which numba may be worth loading."""
        if len(points) >= _MANY:
            return _scan_batch(points, values, box)
        self._scan = scanner(self._budget, self.dimension)
        return self._scan(points, values, box)

    @property
    def trace(self) -> Trace:
        """The improvements so far."""
        return Trace(np.array(self._improved_at, dtype=np.int64), np.array(self._improved_to, dtype=np.float64))


def floats(numbers: ArrayLike, what: str, problem: Problem | None = None) -> Floats:
    """Return a new array of float64; raises TypeError where numpy would drop imaginary parts or a mask, or parse texts.

    The numbers are read once, into memory that nothing else has, row by row.
    """
    if type(numbers) is ndarray and numbers.dtype is _FLOAT64:  # as nearly always, and in a third of the time
        return numbers.copy()
    array = np.asarray(numbers)
    if isinstance(numbers, np.ma.MaskedArray) or array.dtype.kind not in "fiubO":
        whose = what if problem is None else f"{what} of problem {problem.name!r}"
        if array.dtype.kind in "fiubO":
            raise TypeError(f"{whose} must be plain numbers; fill the masked ones with inf or another value")
        raise TypeError(f"{whose} must be real numbers, not {array.dtype}")
    return array.astype(np.float64, order="C")


def repaired(problem: Problem, x: Floats) -> Floats:
    """Repair (n, d) points by the problem's rule; raises ValueError where it changes their shape."""
    given = floats(x, "points")  # the rule may compute in place, or return an array that it keeps
    shape = given.shape
    points = floats(problem.repair(given), "repaired points", problem)
    if points.shape != shape:
        raise ValueError(f"problem {problem.name!r} repaired points of shape {shape} to {points.shape}")
    return points


def as_values(problem: Problem, returned: ArrayLike, n: int) -> Floats:
    """Return a problem's values of n points as a new array, (n,) float64; raises ValueError for another shape."""
    values = floats(returned, "values", problem)
    if values.shape != (n,):
        raise ValueError(f"problem {problem.name!r} returned shape {values.shape} for {n} points")
    return values


def integer_flags(problem: Problem) -> Flags:
    """Return (d,) bool: which variables are whole numbers."""
    return np.zeros(problem.dimension, bool) if problem.integer is None else np.array(problem.integer, bool)


def minus_infinity(problem: Problem) -> ValueError:
    """Return the error of a problem that returned -inf."""
    return ValueError(f"problem {problem.name!r} returned -inf; a value must be finite or +inf")


def _scan(points: Floats, values: Floats, box: Floats) -> tuple[float, int]:
    """Replace the values of points outside the box, and those that are NaN, by +inf.

    Args:
        points: (n, d).
        values: (n,) what the problem returned for them; overwritten.
        box: (2, d), its lower and upper ends.

    Returns:
        The lowest value that counts, and the number of points outside the box; -inf and 0 where any value is -inf.
    """
    lowest, outside = np.inf, 0
    for row in range(len(values)):
        value = values[row]
        if value == -np.inf:
            return value, 0
        inside = True
        for i in range(box.shape[1]):
            inside &= (points[row, i] >= box[0, i]) & (points[row, i] <= box[1, i])  # NaN is not
        outside += not inside
        if not inside or value != value:
            values[row] = np.inf
        elif value < lowest:
            lowest = value
    return lowest, outside


def _scan_batch(points: Floats, values: Floats, box: Floats) -> tuple[float, int]:
    """Do as :func:`_scan`, by numpy."""
    lowest, inside = float(values.min()), (points >= box[0]) & (points <= box[1])
    if lowest > _ILLEGAL and inside.all():  # as nearly always: NaN is the lowest where there is one
        return lowest, 0
    if (values == _ILLEGAL).any():
        return _ILLEGAL, 0
    outside = ~inside.all(axis=1)
    values[outside | np.isnan(values)] = inf
    return float(values.min()), int(outside.sum())


def scanner(budget: int, dimension: int) -> Callable[[Floats, Floats, Floats], tuple[float, int]]:
    """Return :func:`_scan`: compiled, unless the budget is not worth loading numba (0.4 s, 100 MB).

    A process that makes trials of a larger budget later can call this before them, so that none of them waits.
    """
    if "numba" in sys.modules or budget * dimension >= _WORTH_COMPILING:
        loop = compiled(_scan, _SIGNATURE)
        # the arrays are the objective's own: their types need no check in each call
        return getattr(loop, "get_overload", lambda _: loop)(_SIGNATURE)
    return _scan
