"""Run one optimizer once on one problem, in this process."""

from threadpoolctl import threadpool_limits

from bench.errors import BenchError
from bench.numbers import require_seed
from bench.optimizer import Optimizer
from bench.plugins import loading
from bench.problem import Problem
from bench.sandbox.server import end_if_stuck
from bench.scoring import constraints as handlings
from bench.scoring import scored
from bench.trial import Result, search


def solve(
    problem: str | Problem,
    optimizer: str | Optimizer,
    *,
    budget: int,
    seed: int = 0,
    constraints: str = handlings.DEFAULT,
    on_error: str = "fail",
) -> Result:
    """Run one optimizer once on one problem.

    Example:
        >>> bench.solve("signature-12", "gwo", budget=60_000, seed=1).fun

    Args:
        problem: a problem or the name of one.
        optimizer: an optimizer or the name of one.
        budget: evaluations it may spend; it may be less than one generation.
        seed: repeats the run exactly; the ``seed`` of a study's row repeats that trial.
        constraints: what the optimizer sees of infeasible points, as in a study (:mod:`bench.scoring.constraints`).
        on_error: "fail", or "worst" to go on with +inf as the value of a point at which the problem raises.

    Raises:
        BenchError: for an unknown name, a budget below 1, or a handling of constraints or errors that cannot be.
        ProblemError: where the problem raises; its ``raised`` is what the problem raised.
    """
    problem = loading.load_problem(problem) if isinstance(problem, str) else problem
    optimizer = loading.load_optimizer(optimizer) if isinstance(optimizer, str) else optimizer
    if not isinstance(problem, Problem) or not isinstance(optimizer, Optimizer):
        raise BenchError("solve needs a problem and an optimizer, or their names")
    require_seed("the seed", seed)
    problem = scored(problem, handlings.checked(constraints), on_error)
    return make_run(problem, optimizer, budget=budget, seed=seed)


def make_run(problem: Problem, optimizer: Optimizer, *, budget: int, seed: int) -> Result:
    """Make one run as a trial is made, on any problem.

    A process of :mod:`bench.sandbox` ends where the optimizer keeps asking for values after the end of its budget.
    """
    with threadpool_limits(limits=1):  # results and times must not depend on the number of BLAS threads
        return search(problem, optimizer, budget, seed, end_if_stuck)
