"""The complexity of an optimizer as the CEC competitions define it: T0, T1, T2 and (T2 - T1) / T0.

T0 is the time of a million rounds of arithmetic, T1 that of 200,000 evaluations of a function by itself, and T2 that of
the optimizer with as many evaluations of the same function, the mean over five runs. Source: the technical reports of
the competitions, "Algorithm Complexity" (Liang, Qu and Suganthan 2013 for CEC 2014, Awad et al. 2016 for CEC 2017: both
take f18 in 10, 30 and 50 dimensions, the first also in 100). They ask for one style of programming: T0 runs in Python
as an optimizer does, and T1 evaluates as many points a call as the optimizer does on average.

All times are processor seconds of this process, so that other work on the machine counts little.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from time import process_time

import numpy as np
import pandas as pd

from bench.execution.safe_runs import safe_run
from bench.helpers.console import OnStep
from bench.optimizer import Optimizer
from bench.problem import Problem
from bench.seeds import trial_seed

ROUNDS = 1_000_000
WARM_UP = 1_000  # evaluations before any is timed: code may be compiled in the first ones


def baseline(rounds: int = ROUNDS) -> float:
    """Return T0, the processor seconds of the reports' test program."""
    begin = process_time()
    for step in range(1, rounds + 1):
        x = 0.55 + step
        x = x + x
        x = x / 2
        x = x * x
        x = math.sqrt(x)
        x = math.log(x)
        x = math.exp(x)
        x = x / (x + 2)
    return process_time() - begin


def of_function(problem: Problem, evaluations: int, at_once: int, seed: int = 0) -> float:
    """Return T1, the processor seconds of evaluations of points at random in the box, ``at_once`` of them a call."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(problem.lower, problem.upper, (evaluations, problem.dimension))
    calls = [points[first : first + at_once] for first in range(0, evaluations, at_once)]
    begin = process_time()
    for call in calls:
        problem.evaluate(call)
    return process_time() - begin


def complexities(
    optimizers: Mapping[str, Optimizer],
    problems: Mapping[str, Problem],
    evaluations: int = 200_000,
    runs: int = 5,
    seed: int = 0,
    on_progress: OnStep = lambda *_: None,
) -> pd.DataFrame:
    """Return problem, dimension, optimizer, evaluations, points (a call), T0, T1, T2 and complexity, a row a pair.

    An optimizer that ends before the budget has its own number of ``evaluations``, the median of its runs, which T1 has
    as well: its row does not follow the definition.

    Raises:
        BenchError: where an optimizer or a problem fails.
    """
    on_progress("T0", 0, 1 + len(optimizers) * len(problems))
    t0 = min(baseline() for _ in range(3))  # what disturbs a clock only makes it slower
    rows = list(_rows(optimizers, problems, evaluations, runs, seed, on_progress))
    table = pd.DataFrame(rows, columns=["problem", "dimension", "optimizer", "evaluations", "points", "T1", "T2"])
    table.insert(5, "T0", t0)
    return table.assign(complexity=(table["T2"] - table["T1"]) / t0)


def _rows(
    optimizers: Mapping[str, Optimizer],
    problems: Mapping[str, Problem],
    evaluations: int,
    runs: int,
    seed: int,
    on_progress: OnStep,
) -> Iterator[tuple[str, int, str, int, int, float, float]]:
    for place, (label, problem) in enumerate(problems.items()):
        for number, (name, optimizer) in enumerate(optimizers.items()):
            done = 1 + place * len(optimizers) + number
            on_progress(f"{name} on {label}", done, 1 + len(optimizers) * len(problems))
            safe_run(problem, optimizer, budget=min(evaluations, WARM_UP), seed=seed, name=name)
            results = [
                safe_run(problem, optimizer, budget=evaluations, seed=trial_seed(seed, label, name, run), name=name)
                for run in range(runs)
            ]
            spent = int(np.median([result.nfev for result in results]))
            points = max(round(float(np.median([result.nfev / result.calls for result in results]))), 1)
            t1 = of_function(problem, spent, points, seed)
            t2 = float(np.mean([result.cpu_s for result in results]))
            yield label, problem.dimension, name, spent, points, t1, t2
