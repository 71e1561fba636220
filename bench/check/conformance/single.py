"""Make one run as a trial is made, in a process of a check."""

from __future__ import annotations

from threadpoolctl import threadpool_limits

from bench.contract.optimizer import Optimizer
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError, ProblemError
from bench.sandbox.messages import describe_error
from bench.sandbox.server import end_if_stuck
from bench.trial.trial import Result, search

PRINTED = 100_000_000
"""Bytes that a process may print in one call: the file that takes them must not fill the disk."""


def single_run(problem: Problem, optimizer: Optimizer, budget: int, seed: int, name: str = "the optimizer") -> Result:
    """Make one run; its process ends where the optimizer keeps asking for values after the end of its budget.

    Raises:
        BenchError: where the problem raises, or the optimizer, which the sentence calls ``name``.
    """
    try:
        with threadpool_limits(limits=1):  # results and times must not depend on the number of BLAS threads
            return search(problem, optimizer, budget, seed, end_if_stuck)
    except BenchError:
        raise
    except ProblemError as error:
        raise BenchError(f"{problem.name} failed: {describe_error(error)}") from error
    except (Exception, SystemExit) as error:  # a plug-in may raise anything
        raise BenchError(f"{name} failed on {problem.name}: {describe_error(error)}") from error
