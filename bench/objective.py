"""The objective, all that an optimizer sees of a problem: a counted and clocked function with a hard budget."""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bench.numbers import require_whole
from bench.problem import Floats, Problem
from bench.text import printable

_LONGEST_REASON = 200  # characters


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
        found = np.searchsorted(self.evaluations, np.asarray(evaluations), side="right")
        return np.concatenate(([np.inf], self.values))[found]


class Objective:
    """The function that an optimizer minimises, and all that it may know of the problem.

    ``objective(x)`` takes (n, d) points and returns (n,) values, or one (d,) point and returns a float. Every row
    counts as one evaluation; a row outside the box or not finite is counted too, and its value is +inf, so
    leaving the box gains nothing. A NaN value counts as +inf. No row past the budget is evaluated.

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
        self.lower.flags.writeable = self.upper.flags.writeable = False
        self.outside_box = 0
        self.seconds = 0.0  # spent inside the problem's evaluate
        self.best_value = np.inf
        self.best_point: Floats | None = None
        self._budget = budget
        self._evaluations = 0
        self._stop_reason: str | None = None
        self._problem = problem
        self._rng = rng
        self._improved_at: list[int] = []
        self._improved_to: list[float] = []
        self._refusals = 0
        self._on_refusal = on_refusal
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
        return self.budget - self.evaluations

    def repair(self, x: Floats) -> Floats:
        """Return the (n, d) feasible points nearest to ``x`` by the problem's rule; costs no evaluation."""
        repaired = _floats(self._problem.repair(x), f"repaired points of problem {self._problem.name!r}")
        if repaired.shape != np.shape(x):
            raise ValueError(
                f"problem {self._problem.name!r} repaired points of shape {np.shape(x)} to {repaired.shape}"
            )
        return repaired

    def initial(self, n: int) -> Floats:
        """Return (n, d) points, uniform in the box and then repaired, independent in every trial."""
        span = self.upper - self.lower
        return self.repair(self.lower + span * self._rng.random((n, self.dimension)))

    def stop(self, reason: str) -> None:
        """Declare that the optimizer ends before its budget by a criterion of its own, such as ``"tolfun"``."""
        self._stop_reason = printable(" ".join(str(reason).split()), _LONGEST_REASON)

    def __call__(self, x: ArrayLike) -> Any:
        """Return the (n,) values of (n, d) points, or the float of one (d,) point.

        Raises:
            BudgetExhausted: when the budget ends before the last row; the rows it still holds are evaluated and kept.
            ValueError: for points of another shape.
            TypeError: for points that are no real numbers.
        """
        points = _floats(x, "points")
        single = points.ndim == 1
        rows = points[np.newaxis] if single else points
        if rows.ndim != 2 or rows.shape[1] != self.dimension:
            raise ValueError(
                f"expected points of shape (n, {self.dimension}) or ({self.dimension},), got {points.shape}"
            )
        with self._lock:
            allowed = min(len(rows), self.remaining)
            values = self._evaluate(rows[:allowed])
        if allowed < len(rows):
            self._refusals += 1
            if self._on_refusal is not None:
                self._on_refusal(self._refusals)
            raise BudgetExhausted
        return float(values[0]) if single else values

    def _evaluate(self, rows: Floats) -> Floats:
        if not len(rows):
            return np.empty(0)
        given = rows.copy()  # a problem that writes into its argument must not move the optimizer's points
        started = perf_counter()
        values = self._problem.evaluate(given)
        self.seconds += perf_counter() - started
        values = _floats(values, f"values of problem {self._problem.name!r}")
        if values.shape != (len(rows),):
            raise ValueError(f"problem {self._problem.name!r} returned shape {values.shape} for {len(rows)} points")
        if (values == -np.inf).any():
            raise ValueError(f"problem {self._problem.name!r} returned -inf; a value must be finite or +inf")
        inside = ((rows >= self.lower) & (rows <= self.upper)).all(axis=1)
        if not inside.all() or np.isnan(values).any():
            self.outside_box += int(len(rows) - inside.sum())
            values = np.where(inside & ~np.isnan(values), values, np.inf)
        self._record(rows, values)
        self._evaluations += len(rows)
        return values

    def _record(self, rows: Floats, values: Floats) -> None:
        """Append every improvement within the batch to the trace, in order, and keep the best point."""
        if self.best_point is not None and not values.min() < self.best_value:
            return
        before = np.minimum.accumulate(np.concatenate(([self.best_value], values[:-1])))
        for row in np.flatnonzero(values < before):
            self._improved_at.append(self.evaluations + int(row) + 1)
            self._improved_to.append(float(values[row]))
        best = int(np.argmin(values))
        self.best_value = float(values[best])
        self.best_point = rows[best].copy()

    @property
    def trace(self) -> Trace:
        """The improvements so far."""
        return Trace(np.array(self._improved_at, dtype=np.int64), np.array(self._improved_to, dtype=np.float64))


def _floats(given: ArrayLike, what: str) -> Floats:
    """Return an array of float64; raises TypeError where numpy would drop imaginary parts or parse strings."""
    array = np.asarray(given)
    if array.dtype.kind not in "fiubO":
        raise TypeError(f"{what} must be real numbers, not {array.dtype}")
    return array.astype(np.float64, copy=False)
