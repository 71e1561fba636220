"""The objective, all that an optimizer sees of a problem: a counted and clocked function with a hard budget."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from threading import Lock
from time import perf_counter
from typing import Any

import numpy as np
from numpy import empty, ndarray
from numpy.typing import ArrayLike, NDArray

from bench.helpers.compiled import compiled
from bench.helpers.text import printable, said
from bench.numbers import require_whole
from bench.problem import Problem
from bench.typing import Flags, Floats

_LONGEST_REASON = 200  # characters
_FLOAT64 = np.dtype(np.float64)
_NOT_ONE_FLOAT = (None,)
_INSIDE, _OUTSIDE, _MISFIT = 0, 1, 2  # where a point is: in the box, outside, in a space of another dimension
_ILLEGAL = -1
_WORTH_COMPILING = 10_000  # coordinates of points, with which an interpreter is busy for a few milliseconds


class BudgetExhausted(BaseException):
    """Raised by an objective that has no evaluation left; the harness catches it, an optimizer need not.

    It is no subclass of Exception, so that an optimizer's own ``except Exception`` does not catch it.
    """


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
        integer: (d,) bool, the variables that are whole numbers. The harness rounds them; an optimizer may use it.
        raised: the first exception that the problem raised at points in the box, None without. It loses the trial, even
            if the optimizer catches it.

    Args:
        problem: what is minimised.
        budget: the number of evaluations allowed, at least 1.
        rng: the trial's stream for initial points, independent of the optimizer's own.
        on_refusal: called whenever points are refused because the budget is spent, with the number of refusals so far.
    """

    def __init__(
        self, problem: Problem, budget: int, rng: np.random.Generator, on_refusal: Callable[[int], None] | None = None
    ) -> None:
        require_whole("the budget of evaluations", budget, 1)
        self.lower: Floats = problem.lower.copy()
        self.upper: Floats = problem.upper.copy()
        self.integer = integer_flags(problem)
        self.lower.flags.writeable = self.upper.flags.writeable = self.integer.flags.writeable = False
        self.outside_box = 0
        self.seconds = 0.0  # spent inside the problem's evaluate
        self.best_value = np.inf
        self.best_point: Floats | None = None
        self._budget = budget
        self._evaluations = 0
        self._stop_reason: str | None = None
        self.raised: BaseException | None = None  # by the problem's own code, at points in the box
        self._problem = problem
        self._rng = rng
        self._improved_at: list[int] = []
        self._improved_to: list[float] = []
        self._refusals = 0
        self._on_refusal = on_refusal
        self._take, self._scan = passes(budget, self.dimension)
        self._box = np.array([self.lower, self.upper, self.lower], dtype=np.float64)  # and the point being evaluated
        self._shape = 1, self.dimension
        self._lock = Lock()  # threads of an optimizer must not exceed the budget together
        self._turns = iter(self._lock.acquire, False)  # each step takes the lock; see __call__

    @property
    def dimension(self) -> int:
        """The number of search variables d."""
        return len(self.lower)

    @property
    def budget(self) -> int:
        """The number of evaluations allowed."""
        return self._budget

    @property
    def evaluations(self) -> int:
        """The number of evaluations made."""
        return self._evaluations

    @property
    def stop_reason(self) -> str | None:
        """The reason that the optimizer declared for ending before its budget, if any."""
        return self._stop_reason

    @property
    def remaining(self) -> int:
        """The number of evaluations left."""
        return self._budget - self._evaluations

    def repair(self, x: Floats) -> Floats:
        """Return the (n, d) feasible points nearest to ``x`` by the problem's rule; costs no evaluation."""
        return repaired(self._problem, x)

    def initial(self, n: int) -> Floats:
        """Return (n, d) points, uniform in the box and then repaired, independent in every trial.

        Of an integer variable, all whole numbers between its bounds are equally probable.
        """
        shares = self._rng.random((n, self.dimension))
        points = self.lower + (self.upper - self.lower) * shares
        if self.integer.any():
            points = np.where(self.integer, np.floor(self.lower + (self.upper - self.lower + 1) * shares), points)
        return self.repair(points)

    def stop(self, reason: str) -> None:
        """Declare that the optimizer ends before its budget by a criterion of its own, such as ``"tolfun"``.

        A study refuses the reason ``"budget"`` of a trial that has evaluations left.
        """
        self._stop_reason = printable(" ".join(said(reason).split()), _LONGEST_REASON)

    def __call__(self, x: ArrayLike) -> Any:
        """Return the (n,) values of (n, d) points, or the float of one (d,) point.

        Raises:
            BudgetExhausted: when the budget ends before the last row; the rows it still holds are evaluated and kept.
            ValueError: for points of another shape.
            TypeError: for points that are no real numbers.
        """
        if type(x) is ndarray and x.dtype is _FLOAT64:  # the short way of a single point; all else goes the long way
            # As safe as "with self._lock" and half as expensive: no signal can strike between taking the lock and the
            # try. It could after a call of acquire; an optimizer that goes on after its own time limit would then hang.
            for _ in self._turns:
                try:
                    point = empty(self._shape)
                    place = self._take(x, self._box, point) if x.ndim == 1 else _MISFIT
                    if place == _MISFIT or self._evaluations >= self._budget:
                        break
                    began = perf_counter()
                    values = self._problem.evaluate(point)
                    self.seconds += perf_counter() - began
                    try:
                        (value,) = values.tolist() if type(values) is ndarray else _NOT_ONE_FLOAT
                    except (TypeError, ValueError):  # no values, several, or no vector
                        value = None
                    if type(value) is not float:
                        value = self._checked(values, 1).item()
                    if place or value < self.best_value or self.best_point is None:
                        value = self._record_one(value, place)
                    elif value != value:
                        value = np.inf
                    self._evaluations += 1
                    return value
                except (Exception, SystemExit) as error:
                    self._note(error, self._box[2])
                    raise
                finally:
                    self._lock.release()
        points = floats(x, "points")
        single = points.ndim == 1
        rows = points[np.newaxis] if single else points
        if rows.ndim != 2 or rows.shape[1] != self.dimension:
            raise ValueError(
                f"expected points of shape (n, {self.dimension}) or ({self.dimension},), got {points.shape}"
            )
        with self._lock:
            allowed = min(len(rows), self.remaining)
            try:
                values = self._evaluate(rows[:allowed])
            except (Exception, SystemExit) as error:
                self._note(error, rows[:allowed])
                raise
        if allowed < len(rows):
            self._refusals += 1
            if self._on_refusal is not None:
                self._on_refusal(self._refusals)
            raise BudgetExhausted
        return float(values[0]) if single else values

    def _note(self, error: BaseException, points: Floats) -> None:
        """Note the first exception of the problem's code; one at a point outside the box is the optimizer's fault."""
        if self.raised is None and bool(((points >= self.lower) & (points <= self.upper)).all()):
            self.raised = error

    def _evaluate(self, rows: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points, recorded and counted."""
        n = len(rows)
        if not n:
            return empty(0)
        kept = rows.copy()
        points = kept.copy()
        began = perf_counter()
        returned = self._values(points)
        self.seconds += perf_counter() - began
        values, improved = empty(n), empty(n, dtype=np.int64)
        improvements, outside = self._scan(
            kept, self._checked(returned, n), self._box, self.best_value, values, improved
        )
        if improvements == _ILLEGAL:
            raise minus_infinity(self._problem)
        self.outside_box += outside
        if improvements:
            better = improved[:improvements]
            self._improved_at += (better + (self._evaluations + 1)).tolist()
            self._improved_to += values[better].tolist()
            self.best_value = self._improved_to[-1]
            self.best_point = kept[better[-1]].copy()
        elif self.best_point is None:
            self.best_point = kept[0].copy()
        self._evaluations += n
        return values

    def _values(self, x: Floats) -> ArrayLike:
        """Return the values to record of the (n, d) points, as the problem returns them."""
        return self._problem.evaluate(x)

    def _record_one(self, value: float, place: int) -> float:
        """Return what the point in the last row of the box is worth, and record it where it is the best so far."""
        if value == -np.inf:
            raise minus_infinity(self._problem)
        if place == _OUTSIDE:
            self.outside_box += 1
        if place == _OUTSIDE or value != value:
            value = np.inf
        if value < self.best_value:
            self._improved_at.append(self._evaluations + 1)
            self._improved_to.append(value)
            self.best_value = value
            self.best_point = self._box[2].copy()
        elif self.best_point is None:
            self.best_point = self._box[2].copy()
        return value

    def _checked(self, values: ArrayLike, n: int) -> Floats:
        """Return what the problem returned for n points as (n,) float64."""
        return as_values(self._problem, values, n)

    @property
    def trace(self) -> Trace:
        """The improvements so far."""
        return Trace(np.array(self._improved_at, dtype=np.int64), np.array(self._improved_to, dtype=np.float64))


def floats(numbers: ArrayLike, what: str) -> Floats:
    """Return an array of float64; raises TypeError where numpy would drop imaginary parts or a mask, or parse texts."""
    if isinstance(numbers, np.ma.MaskedArray):
        raise TypeError(f"{what} must be plain numbers; fill the masked ones with inf or another value")
    array = np.asarray(numbers)
    if array.dtype.kind not in "fiubO":
        raise TypeError(f"{what} must be real numbers, not {array.dtype}")
    return array.astype(np.float64, copy=False)


def repaired(problem: Problem, x: Floats) -> Floats:
    """Return what a problem's rule makes of the (n, d) points; raises ValueError where it changes their shape."""
    given = floats(x, "points").copy()  # the rule may compute in place, or return an array that it keeps
    shape = given.shape
    points = floats(problem.repair(given), f"repaired points of problem {problem.name!r}").copy()
    if points.shape != shape:
        raise ValueError(f"problem {problem.name!r} repaired points of shape {shape} to {points.shape}")
    return points


def as_values(problem: Problem, returned: ArrayLike, n: int) -> Floats:
    """Return what a problem returned for n points as (n,) float64; raises ValueError for another shape."""
    values = floats(returned, f"values of problem {problem.name!r}")
    if values.shape != (n,):
        raise ValueError(f"problem {problem.name!r} returned shape {values.shape} for {n} points")
    return values


def integer_flags(problem: Problem) -> Flags:
    """Return (d,) bool: which variables are whole numbers."""
    return np.zeros(problem.dimension, bool) if problem.integer is None else np.array(problem.integer, bool)


def minus_infinity(problem: Problem) -> ValueError:
    """Return the error of a problem that returned -inf."""
    return ValueError(f"problem {problem.name!r} returned -inf; a value must be finite or +inf")


def _take(x: Floats, box: Floats, batch: Floats) -> int:
    """Copy the (d,) point to the last row of the (3, d) box and to ``batch``, (1, d); return where it is."""
    if len(x) != box.shape[1]:
        return _MISFIT
    inside = True
    for i in range(len(x)):
        value = x[i]
        box[2, i] = value
        batch[0, i] = value
        inside &= (value >= box[0, i]) & (value <= box[1, i])  # NaN is not
    return _INSIDE if inside else _OUTSIDE


def _scan(
    points: Floats, returned: Floats, box: Floats, best: float, values: Floats, improved: NDArray[np.int64]
) -> tuple[int, int]:
    """Write what the points are worth to ``values`` and the rows of the improvements on ``best`` to ``improved``.

    Args:
        points: (n, d).
        returned: (n,) what the problem returned for them.
        box: (3, d), its lower and upper ends first.
        best: the best value before.
        values: (n,).
        improved: (n,) int64; only as many as there are improvements are written.

    Returns:
        The numbers of improvements and of points outside the box; _ILLEGAL and 0 where a value is -inf.
    """
    improvements = outside = 0
    for row in range(len(returned)):
        value = returned[row]
        if value == -np.inf:
            return _ILLEGAL, 0
        inside = True
        for i in range(box.shape[1]):
            inside &= (points[row, i] >= box[0, i]) & (points[row, i] <= box[1, i])
        outside += not inside
        if not inside or value != value:
            value = np.inf
        values[row] = value
        if value < best:
            best = value
            improved[improvements] = row
            improvements += 1
    return improvements, outside


def passes(budget: int, dimension: int) -> tuple[Callable[..., int], Callable[..., tuple[int, int]]]:
    """Return :func:`_take` and :func:`_scan`: compiled, unless the budget is not worth loading numba (0.4 s, 100 MB).

    A process that makes trials of a larger budget later can call this before them, so that none of them waits.
    """
    if "numba" in sys.modules or budget * dimension >= _WORTH_COMPILING:
        return _compiled_passes()
    return _take, _scan


@cache
def _compiled_passes() -> tuple[Callable[..., int], Callable[..., tuple[int, int]]]:
    """Compile both, or load them from numba's cache on disk.

    They come without numba's dispatcher, which would take longer than they do. So nothing checks the types of their
    arguments, and others than those declared here would be misread.
    """
    from numba import types

    number, whole, plane = types.float64, types.int64, types.float64[:, ::1]
    any_vector = types.Array(number, 1, "A", readonly=True, aligned=False)
    take = whole(any_vector, plane, plane)
    scan = types.UniTuple(whole, 2)(plane, any_vector, plane, number, number[::1], whole[::1])
    return compiled(_take, take), compiled(_scan, scan)
