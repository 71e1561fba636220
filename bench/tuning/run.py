"""Make the runs of a configuration, each in a process that can be lost."""

from __future__ import annotations

import os
from functools import cache
from typing import Any

from threadpoolctl import threadpool_limits

from bench.plugins import loading
from bench.problem import Problem
from bench.scoring import scored
from bench.scoring.constraints import DEFAULT
from bench.trial import search

STILL_ASKING = 87  # the exit code of a process whose optimizer goes on after the end of its budget
_REFUSALS = 10_000  # calls after the end of the budget until the process is ended


def ready() -> None:
    """Load this module."""


def make_run(optimizer: str, options: dict[str, Any], problem: str, budget: int, seed: int) -> dict[str, Any]:
    """Run a configuration once; return its best value, evaluations, seconds, and the trace as two lists."""
    with threadpool_limits(limits=1):  # results must not depend on the number of BLAS threads
        found = search(_problem(problem), loading.load_optimizer(optimizer, **options), budget, seed, _end_if_stuck)
    trace = {"at": found.trace.evaluations.tolist(), "values": found.trace.values.tolist()}
    return {"fun": found.fun, "evaluations": found.nfev, "seconds": found.time, **trace}


@cache
def _problem(name: str) -> Problem:
    return scored(loading.load_problem(name), DEFAULT)


def _end_if_stuck(number: int) -> None:
    """End this process when an optimizer keeps ignoring BudgetExhausted: nothing else stops it."""
    if number > _REFUSALS:
        os._exit(STILL_ASKING)
