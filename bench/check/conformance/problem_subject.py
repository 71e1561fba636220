"""The problem under check, and what it returns of points as the harness evaluates them."""

from __future__ import annotations

import pickle

import cloudpickle
import numpy as np
from threadpoolctl import threadpool_limits

from bench.check.conformance.recording import RecordedRun, seeded_global_states
from bench.check.conformance.subject import AnySubject
from bench.contract.objective import as_values, integer_flags, repaired
from bench.contract.problem import Problem, with_own_box
from bench.contract.typing import Flags, Floats
from bench.plugins.loading import load_problem
from bench.trial.scoring.problem import violations_of
from bench.trial.trial import numbers

POINTS = 24  # of a run


class ProblemSubject(AnySubject):
    """A problem under check; a run asks it for all that it returns of ``POINTS`` points."""

    kind = "problem"
    base = Problem

    def fresh(self) -> Problem:
        """Return a new instance with these options; raises whatever its construction raises."""
        if isinstance(self.source, str):
            return load_problem(self.source, **self.options)
        if isinstance(self.source, type):
            return with_own_box(self.source(**self.options))
        return with_own_box(pickle.loads(cloudpickle.dumps(self.source)))

    def run(self, *, instance: Problem | None = None, seed: int = 0, global_seed: int = 0) -> RecordedRun:
        """Ask a new instance, or ``instance``, for all that it returns of some points; each row of the record is one.

        Args:
            instance: a problem to ask instead of a new one.
            seed: of the points, added to the subject's own.
            global_seed: of Python's and numpy's global random states during the calls.
        """
        with threadpool_limits(limits=1), seeded_global_states(global_seed) as changed:
            problem = self.fresh() if instance is None else instance
            answers = everything(problem, sample(problem, POINTS, self.seed + seed), seed)
        return RecordedRun(points=answers, touched=tuple(changed))

    def parameters(self, problem: Problem) -> dict[str, str]:
        """Return the problem's declaration as text."""
        names = ("name", "variables", "lower", "upper", "integer", "optimum", "features", "repairs", "noisy", "measure")
        return {name: repr(getattr(problem, name)) for name in names}


def sample(problem: Problem, n: int, seed: int) -> Floats:
    """Return (n, d) random points as a trial evaluates them: in the box, every second repaired, integers rounded."""
    rng, flags = np.random.default_rng(seed), integer_flags(problem)
    x = rng.uniform(problem.lower, problem.upper, (n, problem.dimension))
    x[1::2] = repaired(problem, x[1::2])
    return rounded(x, flags)


def rounded(x: Floats, flags: Flags) -> Floats:
    """Return the (n, d) points with whole numbers in place of integer variables."""
    return np.where(flags, np.rint(x), x)


def true_values(problem: Problem, x: Floats) -> Floats:
    """Return the (n,) values without noise of the (n, d) points; raises ValueError for another shape."""
    return as_values(problem, problem.noiseless(x.copy()), len(x))


def feasible_values(problem: Problem, x: Floats) -> Floats:
    """Return the (n,) true values of the (n, d) points, +inf where a constraint is violated."""
    return np.where((violations_of(problem, x) <= 0).all(axis=1), true_values(problem, x), np.inf)


def observed(problem: Problem, x: Floats, seed: int) -> Floats:
    """Return the (n,) values of a noisy problem as a trial with this seed would see them."""
    rng = np.random.default_rng(seed)
    return as_values(problem, problem.evaluate(x.copy(), rng), len(x))  # type: ignore[call-arg]


def everything(problem: Problem, x: Floats, seed: int) -> Floats:
    """Return all that a problem answers, a row for each of the (n, d) points: values, repaired points, violations."""
    columns = [true_values(problem, x)[:, None], repaired(problem, x), violations_of(problem, x)]
    if problem.noisy:
        columns.append(observed(problem, x, seed)[:, None])
    described = [[value for _, value in sorted(numbers(problem.describe(row.copy())).items())] for row in x]
    return np.hstack([*columns, np.array(described).reshape(len(x), -1)])
