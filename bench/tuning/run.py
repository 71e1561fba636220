"""Make the runs of a configuration, each in a process that can be lost."""

from __future__ import annotations

from functools import cache
from typing import Any

from bench.execution.safe_runs import safe_run
from bench.plugins import loading
from bench.problem import Problem
from bench.scoring import scored
from bench.scoring.constraints import DEFAULT


def ready() -> None:
    """Load this module."""


def make_run(optimizer: str, options: dict[str, Any], problem: str, budget: int, seed: int) -> dict[str, Any]:
    """Run a configuration once; return its best value, evaluations, seconds, and the trace as two arrays."""
    result = safe_run(_problem(problem), loading.load_optimizer(optimizer, **options), budget=budget, seed=seed)
    trace = {"at": result.trace.evaluations, "values": result.trace.values}
    return {"fun": result.fun, "nfev": result.nfev, "wall_s": result.wall_s, **trace}


@cache
def _problem(name: str) -> Problem:
    return scored(loading.load_problem(name), DEFAULT)
