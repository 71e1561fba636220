"""Record how optimizers search: trials in this process, with every point that they evaluate."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from bench.analysis.similarity import behaviour
from bench.check.problems import FUNCTIONS, RecordingProblem, classic
from bench.execution.safe_runs import safe_run
from bench.helpers.console import OnStep
from bench.optimizer import Optimizer
from bench.problem import Problem
from bench.seeds import trial_seed
from bench.typing import Floats

DIMENSION = 5


def common_problems() -> dict[str, Callable[[], RecordingProblem]]:
    """Return makers of the classic functions, each with its optimum moved away from the centre, by name."""
    return {name: lambda name=name: classic(name, DIMENSION, moved=True) for name in FUNCTIONS}  # type: ignore[misc]


def recorder(problem: Problem) -> RecordingProblem:
    """Return a problem of the same true values that records its points; constraints and noise are left out."""
    return RecordingProblem(
        problem.noiseless, problem.lower, problem.upper, name=problem.name, optimum=problem.optimum,
        integer=problem.integer,
    )  # fmt: skip


def behaviours(
    optimizers: Mapping[str, Optimizer],
    problems: Mapping[str, Callable[[], RecordingProblem]],
    trials: int,
    budgets: Mapping[str, int],
    seed: int = 0,
    on_progress: OnStep = lambda *_: None,
) -> dict[str, Sequence[Floats]]:
    """Run every optimizer on every problem; return, by optimizer, (trials, numbers) for each problem.

    ``budgets`` are the evaluations of a trial on each problem. Precisions are counted from the known optimum, or else
    from the lowest value of any trial.

    Raises:
        BenchError: where an optimizer fails.
    """
    runs: dict[tuple[str, str], list[tuple[Floats, Floats]]] = {}
    for number, (name, optimizer) in enumerate(optimizers.items()):
        for place, (label, make) in enumerate(problems.items()):
            on_progress(f"{name} on {label}", number * len(problems) + place, len(optimizers) * len(problems))
            seeds = (trial_seed(seed, label, name, trial) for trial in range(trials))
            runs[name, label] = [_run(name, optimizer, make(), budgets[label], run_seed) for run_seed in seeds]
    zeros = {}
    for label, make in problems.items():
        optimum = make().optimum
        values = [run_values for name in optimizers for _, run_values in runs[name, label]]
        zeros[label] = optimum if optimum is not None else min(float(run_values.min()) for run_values in values)
    return {
        name: [
            np.array([behaviour(points, values, zeros[label], budgets[label]) for points, values in runs[name, label]])
            for label in problems
        ]
        for name in optimizers
    }


def _run(name: str, optimizer: Optimizer, problem: RecordingProblem, budget: int, seed: int) -> tuple[Floats, Floats]:
    """Return the points of one trial, as shares of the box, and their values."""
    safe_run(problem, optimizer, budget=budget, seed=seed, name=name)
    points = problem.points[:budget]
    return problem.share(points), np.asarray(problem.noiseless(points), dtype=np.float64)
