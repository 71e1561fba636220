"""Record the true values of problems whose optimizers see others: constraints, noise, integer variables, failures.

**The recorded values are those that count**: the objective without noise, at feasible points, with whole numbers in
place of integer variables (:meth:`Scored.evaluate`). Any other point is recorded as +inf. So trace, best value and its
check are those of any problem: the first entry of a trace is the first feasible point, and a trace of a noisy problem
is the lowest true value among the points evaluated so far, as in COCO's noisy suite (Hansen, Finck, Ros and Auger 2009,
INRIA RR-6869). What an optimizer sees instead:

- of an infeasible point, what the study's handling of constraints shows (:mod:`bench.trial.scoring.constraints`);
- of a noisy problem, values with noise from a stream of the trial's own;
- of a point whose evaluation raises, +inf, where the study says ``on_error = "worst"``; it is recorded as such, too;
- of integer variables, the value of the point whose integer variables are rounded. It need not know of them; one that
  does finds them in ``objective.integer``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bench.contract.objective import Objective, OnEvaluation, as_values, floats, minus_infinity, repaired
from bench.contract.problem import Problem, with_own_box
from bench.contract.typing import Flags, Floats
from bench.helpers.errors import BenchError, PointError, explained
from bench.trial.scoring import constraints

ON_ERROR = ("fail", "worst")
"""What becomes of a point at which a problem raises: the trial fails, or the point counts and its value is +inf."""


class Assessment(NamedTuple):
    """The values of n points: those recorded, and those that the optimizer sees.

    Attributes:
        points: (n, d) the points in whose place values are recorded: repaired where the handling repairs, and rounded.
        values: (n,) the values to record, +inf where a point is infeasible.
        shown: (n,) what the optimizer sees.
        violation: (n,) their total violations, 0 where they are feasible.
        failed: the number of points whose evaluation failed, where the study goes on.
    """

    points: Floats
    values: Floats
    shown: Floats
    violation: Floats
    failed: int


class Scored(Problem):
    """A problem with constraints, noise, integer variables or points that fail; it returns the recorded values.

    The domain metrics of a constrained problem have the ``violation`` of the point.

    Attributes:
        problem: the problem itself.
        handling: one of :data:`bench.trial.scoring.constraints.HANDLINGS`; "" without constraints.
        on_error: one of :data:`ON_ERROR`.
    """

    def __init__(self, problem: Problem, handling: str, on_error: str = "fail") -> None:
        self.problem, self.handling, self.on_error = problem, handling, on_error
        self.failed = 0  # evaluations so far that failed, where the study goes on
        self.name, self.variables = problem.name, problem.variables
        self.lower, self.upper = problem.lower, problem.upper
        self.optimum, self.expected, self.features = problem.optimum, dict(problem.expected), dict(problem.features)
        self.integer, self.initial_points = problem.integer, problem.initial_points
        if not handling:  # handled constraints confine all optimizers alike
            self.repaired_optimum = problem.repaired_optimum

    @property
    def unscored(self) -> Problem:
        """The problem whose values are recorded."""
        return self.problem

    def evaluate(self, x: Floats) -> Floats:
        """Return the (n,) values recorded of the (n, d) points ``x``: true ones, and +inf where they are infeasible."""
        x = self.rounded(x)
        return self._feasible(self._true(x), self._total(x))

    def assess(self, x: Floats, rng: np.random.Generator) -> Assessment:
        """Assess the (n, d) points ``x``, all in the box; noise is drawn from ``rng``."""
        if self.handling == "repair":
            x = repaired(self.problem, x)
        x = self.rounded(x)
        before = self.failed
        true, total = self._true(x), self._total(x)
        failed = self.failed - before
        if self.handling == "repair":  # nothing else has checked these
            total = np.where(((x >= self.lower) & (x <= self.upper)).all(axis=1), total, np.inf)
        seen = self._observed(x, rng) if self.problem.noisy else true
        shown = constraints.visible_values(self.handling, seen, total)
        return Assessment(x, self._feasible(true, total), shown, total, failed)

    def rounded(self, x: Floats) -> Floats:
        """Return the (n, d) points with whole numbers in place of integer variables."""
        return x if self.integer is None else np.where(self.integer, np.rint(x), x)

    def violations(self, x: Floats) -> Floats | None:
        """Return the (n, m) violations of the (n, d) points ``x``; a point is feasible where all are at most 0."""
        return violations_of(self.problem, x) if self.handling else None

    def repair(self, x: Floats) -> Floats:
        """Return the points nearest to the (n, d) ``x`` by the problem's own rule."""
        return self.problem.repair(x)

    def describe(self, x: Floats) -> dict[str, float]:
        """Return the problem's domain metrics of the (d,) point ``x``, and its total ``violation``."""
        metrics, violations = self.problem.describe(x.copy()), self.violations(x[np.newaxis])
        constrained = violations is not None and violations.size
        return {**metrics, "violation": float(self._total(x[np.newaxis])[0])} if constrained else metrics

    def _true(self, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points without noise, whether they are feasible or not."""
        return self._computed(self.problem.noiseless, x)

    def _computed(self, values: Callable[[Floats], Floats], x: Floats) -> Floats:
        """Call a function of the problem with the (n, d) points; return +inf where it may fail and raises."""
        alone = len(x) > 1 and self.on_error == "worst" and self.problem.by_point
        try:
            if not alone:
                return as_values(self.problem, values(x.copy()), len(x))
        except PointError as error:
            if self.on_error == "fail":
                raise
            self.failed += error.failed
            done = np.array(error.values, dtype=np.float64)
            left = x[len(done) :]
            return np.concatenate([done, self._computed(values, left)]) if len(left) else done
        except Exception:  # a plug-in may raise anything
            if self.on_error == "fail":
                raise
        if len(x) == 1:
            self.failed += 1
            return np.full(1, np.inf)
        return np.concatenate([self._computed(values, row[np.newaxis]) for row in x])

    def _observed(self, x: Floats, rng: np.random.Generator) -> Floats:
        """Return the (n,) values of the (n, d) points with noise."""
        observed = self._computed(lambda points: self.problem.evaluate(points, rng), x)  # type: ignore[call-arg]
        if (observed == -np.inf).any():
            raise minus_infinity(self.problem)
        return observed

    def _total(self, x: Floats) -> Floats:
        """Return the (n,) total violations: NaN among the violations of a point makes its total +inf."""
        violations = self.violations(x)
        if violations is None:
            return np.zeros(len(x))
        with np.errstate(over="ignore"):
            total: Floats = np.where(violations <= 0, 0.0, violations).sum(axis=1)
        return np.where(np.isnan(total), np.inf, total)

    @staticmethod
    def _feasible(true: Floats, total: Floats) -> Floats:
        # -inf stays where it is, for the objective to refuse it.
        return np.where((total <= 0) | (true == -np.inf), true, np.inf)


class ScoredObjective(Objective):
    """The objective of a :class:`Scored` problem: the optimizer sees other values than those that are recorded.

    Until a feasible point is found, the best point is the one in the box that violates the constraints least.
    """

    _problem: Scored

    def __init__(self, problem: Scored, *others: Any) -> None:
        super().__init__(problem, *others)
        self._compute = self._assessed
        self._noise = self._rng.spawn(1)[0]  # a stream that initial points do not share
        self._found: Assessment  # of the points under evaluation
        self._least = np.inf

    def _assessed(self, x: Floats) -> Floats:
        self._found = self._problem.assess(x, self._noise)
        self.failures += self._found.failed
        return self._found.values

    def _evaluate(self, rows: Floats) -> Floats:
        before, none = self.fun, self.best_point is None
        values = super()._evaluate(rows)
        if not len(rows):
            return values
        assessment = self._found
        inside = ((rows >= self.lower) & (rows <= self.upper)).all(axis=1)
        violation = np.where(inside, assessment.violation, np.inf)
        least = int(violation.argmin())
        if self.fun < before:
            self.best_point = assessment.points[int(values.argmin())].copy()
        elif self.fun == np.inf and violation[least] < self._least:
            self._least = float(violation[least])
            self.best_point = assessment.points[least].copy()
        elif none:  # no point of a trial lies in the box so far
            self.best_point = self._problem.rounded(rows[:1])[0]
        return np.where(inside, assessment.shown, np.inf)


def scored(problem: Problem, handling: str, on_error: str = "fail") -> Problem:
    """Return a problem with constraints, noise or integer variables as scored, and any other problem as it is.

    Args:
        problem: any problem.
        handling: what an optimizer sees of infeasible points.
        on_error: one of :data:`ON_ERROR`; with "worst", any problem is scored.

    Raises:
        BenchError: for another ``on_error``, for bounds that are not a box, for ``repair`` of a problem whose repair
            does not satisfy its constraints, for a problem whose violations cannot be computed, and for integer
            variables that cannot be.
    """
    require_on_error(on_error)
    if isinstance(problem, Scored):
        return problem
    with_own_box(problem)
    constrained = _constrained(problem)
    if constrained and handling == "repair" and not problem.repairs:
        usable = ", ".join(name for name in constraints.HANDLINGS if name != "repair")
        raise BenchError(
            f"problem {problem.name!r} has no rule that repairs violated constraints; choose another handling: {usable}"
        )
    if problem.integer is not None:
        _check_integer(problem, problem.integer)
    if constrained or problem.noisy or problem.integer is not None or on_error == "worst":
        return Scored(problem, constraints.read_handling(handling) if constrained else "", on_error)
    return problem


def violations_of(problem: Problem, x: Floats) -> Floats:
    """Return the (n, m) violations of the (n, d) points, m = 0 without constraints; raises ValueError otherwise."""
    returned = problem.violations(x.copy())
    if returned is None:
        return np.empty((len(x), 0))
    excess = floats(returned, "violations", problem)
    if excess.ndim != 2 or len(excess) != len(x):
        raise ValueError(f"problem {problem.name!r} returned violations of shape {excess.shape} for {len(x)} points")
    return excess


def require_on_error(value: object, what: str = "'on_error'") -> str:
    """Return one of :data:`ON_ERROR`; raises BenchError for anything else, naming it ``what``."""
    if value not in ON_ERROR:
        raise BenchError(f'{what} must be "fail" or "worst", not {value!r}')
    return str(value)


def _constrained(problem: Problem) -> bool:
    """Return whether a problem has constraints."""
    if type(problem).violations is Problem.violations or problem.joint:
        return problem.joint
    with explained(f"problem {problem.name!r}: its violations cannot be computed", Exception):
        return bool(violations_of(problem, problem.lower[np.newaxis]).size)


def _check_integer(problem: Problem, flags: Flags) -> None:
    """Raise BenchError unless there is a flag for each variable, and integer variables have whole numbers as bounds."""
    if np.shape(flags) != (problem.dimension,) or np.asarray(flags).dtype != bool:
        raise BenchError(
            f"problem {problem.name!r}: its attribute integer must be {problem.dimension} flags, one for each variable"
        )
    for bounds in (problem.lower, problem.upper):
        if (wrong := flags & (np.rint(bounds) != bounds)).any():
            raise BenchError(
                f"problem {problem.name!r}: its integer variable {problem.variables[int(wrong.argmax())]!r} is bounded "
                f"by {float(bounds[wrong][0])!r}; give whole numbers as bounds"
            )


def objective(
    problem: Problem,
    budget: int,
    rng: np.random.Generator,
    on_refusal: Callable[[int], None] | None = None,
    seconds: float | None = None,
    goal: float = -np.inf,
    on_evaluation: OnEvaluation | None = None,
) -> Objective:
    """Return the objective of a trial on the problem; see :class:`Objective` for the arguments."""
    kind: Callable[..., Objective] = ScoredObjective if isinstance(problem, Scored) else Objective
    return kind(problem, budget, rng, on_refusal, seconds, goal, on_evaluation)
