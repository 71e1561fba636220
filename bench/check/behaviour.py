"""Record how optimizers search: trials in processes that can be lost, with every point that they evaluate."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from bench.analysis.similarity import behaviour
from bench.check.problems import FUNCTIONS, RecordingProblem, classic
from bench.execution.safe_runs import found, safe_run, safe_runs
from bench.helpers.console import OnStep
from bench.plugins import loading
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


def recorders(names: Sequence[str]) -> dict[str, Callable[[], RecordingProblem]]:
    """Return makers of the problems of these names, or of the common ones where there is none."""
    return {name: partial(_loaded, name) for name in names} or common_problems()


def _loaded(name: str) -> RecordingProblem:
    return recorder(loading.load_problem(name))


def behaviours(
    optimizers: Sequence[str],
    options: Mapping[str, object],
    problems: Sequence[str],
    trials: int,
    budgets: Mapping[str, int],
    seed: int = 0,
    jobs: int = 1,
    on_progress: OnStep = lambda *_: None,
) -> dict[str, Sequence[Floats]]:
    """Run every optimizer on every problem; return, by optimizer, (trials, numbers) for each problem.

    Precisions are counted from the known optimum, or else from the lowest value of any trial.

    Args:
        optimizers: their names.
        options: of all of them.
        problems: their names; the common ones where there is none.
        trials: of each on each.
        budgets: the evaluations of a trial by problem (:func:`recorders`).
        seed: of the trials.
        jobs: trials made at a time, -1 for one a core; no trial depends on it.
        on_progress: called before an optimizer's trials on a problem are awaited.

    Raises:
        BenchError: where an optimizer fails.
    """
    runs: dict[tuple[str, str], list[tuple[Floats, Floats]]] = {}
    makers = recorders(problems)
    with safe_runs(jobs, ready) as begin:
        begun = {
            (name, label): [
                begin(
                    name,
                    record,
                    name,
                    dict(options),
                    list(problems),
                    label,
                    budgets[label],
                    trial_seed(seed, label, name, trial),
                )
                for trial in range(trials)
            ]
            for name in optimizers
            for label in makers
        }
        for number, ((name, label), futures) in enumerate(begun.items()):
            on_progress(f"{name} on {label}", number, len(begun))
            runs[name, label] = [found(each, lambda made: (made["points"], made["values"]), name) for each in futures]
    zeros = {}
    for label, make in makers.items():
        optimum = make().optimum
        values = [run_values for name in optimizers for _, run_values in runs[name, label]]
        zeros[label] = optimum if optimum is not None else min(float(run_values.min()) for run_values in values)
    return {
        name: [
            np.array([behaviour(points, values, zeros[label], budgets[label]) for points, values in runs[name, label]])
            for label in makers
        ]
        for name in optimizers
    }


def ready() -> None:
    """Load this module."""


def record(
    name: str, options: dict[str, Any], problems: list[str], label: str, budget: int, seed: int
) -> dict[str, Floats]:
    """Return the points of one trial, as shares of the box, and their values."""
    problem = recorders(problems)[label]()
    safe_run(problem, loading.load_optimizer(name, **options), budget=budget, seed=seed, name=name)
    points = problem.points[:budget]
    return {"points": problem.share(points), "values": np.asarray(problem.noiseless(points), dtype=np.float64)}
