"""The handling of constraints: what an optimizer sees of a constrained problem, and what is recorded of it.

Whatever the handling, **only feasible points are recorded**: a constrained problem's value is its objective at a
feasible point and +inf at any other (:meth:`Handled.evaluate`), so trace, best value and its check are those of any
problem, and the first entry of a trace is the first feasible point. The handling decides what the optimizer sees at
an infeasible point, by its total violation G(x) = Σ max(0, g_i(x)):

================= ===================================================================================================
``death``         +inf
``penalty``       f(x) + R G(x) with R = 10⁶, a static penalty
``lexicographic`` B (1 + G(x)) with B = 10¹⁰⁰; a feasible value of B or more appears as the float below B
``repair``        the value of the repaired point, in whose place it is recorded; +inf where that is infeasible too
================= ===================================================================================================

``lexicographic`` orders points as Deb (2000): feasible before infeasible, feasible ones by f, infeasible ones by G.
One float suffices: B (1 + G) >= B exceeds every feasible value shown, and does not decrease with G, which rounding
keeps; two violations whose difference is below 2.2e-16 (1 + G) are equal. B is a power at which squares, sums
and differences of values do not overflow yet, for optimizers that calculate with them. A point whose violation is NaN
or infinite is +inf in every handling, and so is a feasible point whose objective is NaN or +inf.

References:
    Coello Coello (2002), Theoretical and numerical constraint-handling techniques used with evolutionary algorithms: a
    survey of the state of the art, Comput. Methods Appl. Mech. Eng. 191:1245-1287 (death, static penalties, repair).
    Deb (2000), An efficient constraint handling method for genetic algorithms, the same journal 186:311-338.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bench.errors import BenchError, nearest
from bench.objective import Objective, as_values, floats, repaired
from bench.problem import Floats, Problem

HANDLINGS = ("death", "penalty", "lexicographic", "repair")
DEFAULT = "lexicographic"  # it needs no coefficient, and leads an optimizer from infeasible points, unlike death
COEFFICIENT = 1e6  # R
BARRIER = 1e100  # B


class Assessment(NamedTuple):
    """What n points of a constrained problem are worth.

    Attributes:
        points: (n, d), repaired where the handling repairs.
        values: (n,) their objective values where they are feasible, else +inf.
        shown: (n,) what the optimizer sees.
        violation: (n,) their total violations, 0 where they are feasible.
    """

    points: Floats
    values: Floats
    shown: Floats
    violation: Floats


class Handled(Problem):
    """A constrained problem under one of the ``HANDLINGS``; its domain metrics have the ``violation`` of the point.

    Attributes:
        problem: the constrained problem itself.
        handling: one of ``HANDLINGS``.
    """

    def __init__(self, problem: Problem, handling: str) -> None:
        self.problem, self.handling = problem, handling
        self.name, self.variables = problem.name, problem.variables
        self.lower, self.upper = problem.lower, problem.upper
        self.optimum, self.expected, self.features = problem.optimum, dict(problem.expected), dict(problem.features)

    def evaluate(self, x: Floats) -> Floats:
        """Return the (n,) objective values of the (n, d) points ``x`` where they are feasible, else +inf."""
        return self._feasible(*self._measured(x))

    def assess(self, x: Floats) -> Assessment:
        """Return what the (n, d) points ``x``, all in the box, are worth under the handling."""
        if self.handling == "repair":
            x = repaired(self.problem, x.copy())
        raw, total = self._measured(x)
        if self.handling == "repair":  # nothing else has checked these
            total = np.where(((x >= self.lower) & (x <= self.upper)).all(axis=1), total, np.inf)
        values = self._feasible(raw, total)
        shown = np.where(np.isnan(values), np.inf, values)
        infeasible = total > 0
        if self.handling == "penalty":
            with np.errstate(over="ignore", invalid="ignore"):
                penalised = raw + COEFFICIENT * total
            shown = np.where(infeasible, np.where(np.isnan(penalised), np.inf, penalised), shown)
        elif self.handling == "lexicographic":
            below = np.where(np.isfinite(shown), np.minimum(shown, np.nextafter(BARRIER, 0)), shown)
            with np.errstate(over="ignore"):
                shown = np.where(infeasible, BARRIER * (1 + total), below)
        return Assessment(x, values, shown, total)

    def violations(self, x: Floats) -> Floats:
        """Return the (n, m) violations of the (n, d) points ``x``; a point is feasible where all are at most 0."""
        found = floats(self.problem.violations(x.copy()), f"violations of problem {self.name!r}")  # type: ignore[arg-type]
        if found.ndim != 2 or len(found) != len(x):
            raise ValueError(f"problem {self.name!r} returned violations of shape {found.shape} for {len(x)} points")
        return found

    def repair(self, x: Floats) -> Floats:
        """Return the points nearest to the (n, d) ``x`` by the problem's own rule."""
        return self.problem.repair(x)

    def describe(self, x: Floats) -> dict[str, float]:
        """Return the problem's domain metrics of the (d,) point ``x``, and its total ``violation``."""
        return {**self.problem.describe(x), "violation": float(self._total(x[np.newaxis])[0])}

    def fingerprint(self) -> str:
        """Return a hash of the problem's data and of the handling, which decides its values."""
        return hashlib.sha256(f"{self.handling} {self.problem.fingerprint()}".encode()).hexdigest()[:16]

    def _measured(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the (n,) objective values of the (n, d) points, feasible or not, and their (n,) total violations."""
        total = self._total(x)
        return as_values(self.problem, self.problem.evaluate(x.copy()), len(x)), total

    def _total(self, x: Floats) -> Floats:
        """Return the (n,) total violations: NaN among the violations of a point makes its total +inf."""
        found = self.violations(x)
        with np.errstate(over="ignore"):
            total: Floats = np.where(found <= 0, 0.0, found).sum(axis=1)
        return np.where(np.isnan(total), np.inf, total)

    @staticmethod
    def _feasible(raw: Floats, total: Floats) -> Floats:
        # -inf stays where it is, for the objective to refuse it.
        return np.where((total <= 0) | (raw == -np.inf), raw, np.inf)


class HandledObjective(Objective):
    """The objective of a constrained problem: the optimizer sees other values than those that are recorded.

    Until a feasible point is found, the best point is the one in the box that violates the constraints least.
    """

    _problem: Handled

    def __init__(self, problem: Handled, *others: Any) -> None:
        super().__init__(problem, *others)
        self._found: Assessment  # of the points under evaluation
        self._least = np.inf

    def __call__(self, x: ArrayLike) -> Any:
        """Return the (n,) values of (n, d) points, or the float of one (d,) point; see :class:`Objective`."""
        points = floats(x, "points")
        if points.ndim == 1:
            return float(super().__call__(points[np.newaxis])[0])
        return super().__call__(points)

    def _values(self, x: Floats) -> Floats:
        self._found = self._problem.assess(x)
        return self._found.values

    def _evaluate(self, rows: Floats) -> Floats:
        kept, before = rows.copy(), self.best_value
        values = super()._evaluate(kept)
        if not len(kept):
            return values
        found = self._found
        inside = ((kept >= self.lower) & (kept <= self.upper)).all(axis=1)
        violation = np.where(inside, found.violation, np.inf)
        least = int(violation.argmin())
        if self.best_value < before:
            self.best_point = found.points[int(values.argmin())].copy()
        elif self.best_value == np.inf and violation[least] < self._least:
            self._least = float(violation[least])
            self.best_point = found.points[least].copy()
        return np.where(inside, found.shown, np.inf)


def handled(problem: Problem, handling: str) -> Problem:
    """Return a constrained problem under the handling, and any other problem as it is.

    Raises:
        BenchError: for ``repair`` of a problem whose repair does not satisfy its constraints, and for a problem whose
            violations cannot be computed.
    """
    if isinstance(problem, Handled) or type(problem).violations is Problem.violations:
        return problem
    try:
        found = problem.violations(problem.lower[np.newaxis].copy())
        if found is not None and np.ndim(found) != 2:
            raise ValueError(f"they have the shape {np.shape(found)}, not (n, m)")
    except Exception as error:  # a plug-in may raise anything
        raise BenchError(
            f"problem {problem.name!r}: its violations cannot be computed: {type(error).__name__}: {error}"
        ) from error
    if found is None or not np.size(found):
        return problem
    if handling == "repair" and not problem.repairs:
        others = ", ".join(each for each in HANDLINGS if each != "repair")
        raise BenchError(
            f"problem {problem.name!r} has no rule that repairs violated constraints; choose another handling: {others}"
        )
    return Handled(problem, checked(handling))


def plain(problem: Problem) -> Problem:
    """Return the problem itself, without the handling of its constraints."""
    return problem.problem if isinstance(problem, Handled) else problem


def objective(
    problem: Problem, budget: int, rng: np.random.Generator, on_refusal: Callable[[int], None] | None = None
) -> Objective:
    """Return the objective of a trial on the problem; see :class:`Objective` for the arguments."""
    kind: Callable[..., Objective] = HandledObjective if isinstance(problem, Handled) else Objective
    return kind(problem, budget, rng, on_refusal)


def checked(handling: Any, what: str = "'constraints'") -> str:
    """Return the handling; raises BenchError for an unknown one, naming it ``what``."""
    if handling not in HANDLINGS:
        hint = nearest(handling, HANDLINGS) if isinstance(handling, str) else ""
        raise BenchError(f"{what} must be one of {', '.join(HANDLINGS)}, not {handling!r}{hint}")
    return str(handling)
