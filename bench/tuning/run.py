"""Make the runs of a configuration, each in a process that can be lost."""

from __future__ import annotations

import os
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from bench.analysis.target_sets import aocc
from bench.constraints import DEFAULT
from bench.execution.trial_process import STILL_ASKING
from bench.plugins import loading
from bench.problem import Problem
from bench.scoring import scored
from bench.trial import search

_REFUSALS = 10_000  # calls after the end of the budget until the process is ended


def ready() -> None:
    """Load this module."""


def make_run(optimizer: str, options: dict[str, Any], problem: str, budget: int, seed: int) -> dict[str, Any]:
    """Run a configuration once; return its precision, its area over the convergence curve, evaluations and seconds."""
    loaded = _problem(problem)
    with threadpool_limits(limits=1):  # results must not depend on the number of BLAS threads
        found = search(loaded, loading.load_optimizer(optimizer, **options), budget, seed, _end_if_stuck)
    optimum = float(loaded.optimum)  # type: ignore[arg-type]  # problems without one are refused before
    row = pd.DataFrame({"problem": [problem], "optimizer": [optimizer], "trial": [0], "status": ["ok"]})
    area = aocc(row, {(problem, optimizer, 0): found.trace}, {problem: optimum}, budget)["aocc"].iloc[0]
    return {
        "precision": float(np.maximum(found.fun - optimum, 0.0)),
        "aocc": float(area),
        "evaluations": found.nfev,
        "seconds": found.time,
    }


@cache
def _problem(name: str) -> Problem:
    return scored(loading.load_problem(name), DEFAULT)


def _end_if_stuck(number: int) -> None:
    """End this process when an optimizer keeps ignoring BudgetExhausted: nothing else stops it."""
    if number > _REFUSALS:
        os._exit(STILL_ASKING)
