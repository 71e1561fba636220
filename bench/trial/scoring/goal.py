"""The value at which a trial ends, as it is good enough: near the known optimum, or one that the user names."""

from __future__ import annotations

from math import inf, nextafter

from bench.contract.numbers import is_finite, require_positive
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError


def goal(problem: Problem, final_target: float | None = None, stop_at: float | None = None) -> float:
    """Return the value that ends a trial on the problem once a feasible point has it; -inf where none does.

    Args:
        problem: what is minimised.
        final_target: the difference to the known optimum, such as 1e-8 in COCO (Hansen et al. 2021).
        stop_at: the value itself.

    Raises:
        BenchError: for a difference to an optimum that is not known.
    """
    value = -inf if stop_at is None else stop_at
    if final_target is None:
        return value
    if problem.optimum is None:
        raise BenchError(
            f"problem {problem.name!r} has no known optimum, from which 'final_target' counts; give 'stop_at', a value"
        )
    near = problem.optimum + final_target
    while near - problem.optimum > final_target:  # the sum is rounded, and reports subtract
        near = nextafter(near, -inf)
    return max(near, value)


def read_final_target(value: object, what: str = "'final_target'") -> float:
    """Return a difference to the optimum; raises BenchError unless it is a positive number, naming it ``what``."""
    return require_positive(what, value)


def read_stop_at(value: object, what: str = "'stop_at'") -> float:
    """Return a value that is good enough; raises BenchError unless it is a finite number, naming it ``what``."""
    if not is_finite(value):
        raise BenchError(f"{what} must be a number, the value that is good enough, not {value!r}")
    return float(value)
