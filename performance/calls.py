"""Measure what a call of the objective costs beside the function that it calls, in one run on one core.

    python performance/calls.py                  # this checkout; beside ioh and cocoex, where they are installed
    python performance/calls.py OTHER_CHECKOUT   # this one and another by turns: before and after

"Beside the function" is the time of ``objective(x)`` less that of ``problem.evaluate`` on an equal array. Both are
called in turn, and the fastest of several rounds counts, so that a busy moment of the machine favours neither. After a
real function the call costs more than after one that returns at once: each displaces a part of the other's code from
the processor's caches.

A run of a whole optimizer counts all that its evaluations cost outside the function, the optimizer's own time included.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import chdir, suppress
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bench import BudgetExhausted, FunctionProblem, Objective, load_optimizer

ROUNDS, SECONDS, POINTS, TURNS = 15, 0.02, 100, 3
ENDLESS = 10**12  # evaluations
RUNS = {
    "a loop over single points": 20_000, "random-search": 300_000, "scipy:differential_evolution": 20_000,
    "nevergrad:OnePlusOne": 2_000,
}  # fmt: skip
HERE = Path(__file__).resolve().parents[1]


def sphere(x: np.ndarray) -> np.ndarray:
    return (x * x).sum(axis=1)


def us_a_call(*timed: tuple[Callable[[Any], Any], list[Any]]) -> list[float]:
    """Return the microseconds a call of each function, on one of its arguments after the other."""
    repeats, fastest = [], [np.inf] * len(timed)
    for function, arguments in timed:
        began = perf_counter()
        for x in arguments:
            function(x)
        repeats.append(max(1, round(SECONDS / (perf_counter() - began))))
    for _ in range(ROUNDS):
        for index, (function, arguments) in enumerate(timed):
            began = perf_counter()
            for _ in range(repeats[index]):
                for x in arguments:
                    function(x)
            took = (perf_counter() - began) / repeats[index] / len(arguments)
            fastest[index] = min(fastest[index], took * 1e6)
    return fastest


def beside(function: Callable[[np.ndarray], Any], n: int | None, d: int) -> tuple[float, float]:
    """Return what the function takes and what a call of the objective takes beside it: n points, or a single one."""
    problem = FunctionProblem(function, [-5.0] * d, [5.0] * d)
    objective = Objective(problem, ENDLESS, np.random.default_rng(0))
    batches = list(np.random.default_rng(1).uniform(-5, 5, (POINTS, n or 1, d)))
    alone, whole = us_a_call((problem.evaluate, batches), (objective, batches if n else [each[0] for each in batches]))
    return alone, whole - alone


def run(label: str, budget: int) -> float:
    """Return the microseconds that an evaluation takes outside the function, in a run of an optimizer at d = 10."""
    problem = FunctionProblem(sphere, [-5.0] * 10, [5.0] * 10)
    objective = Objective(problem, budget, np.random.default_rng(0))
    points = np.random.default_rng(1).uniform(-5, 5, (budget, 10))
    optimizer = None if label.startswith("a loop") else load_optimizer(label)
    began = perf_counter()
    with suppress(BudgetExhausted):
        if optimizer is None:
            for x in points:
                objective(x)
        else:
            optimizer.minimize(objective, np.random.default_rng(0))
    return (perf_counter() - began - objective.seconds) / objective.evaluations * 1e6


def measure() -> dict[str, float]:
    """Return the microseconds of everything measured in this process."""
    found = {}
    for n, d in [(None, 2), (None, 10), (None, 40), (30, 7), (30, 10), (300, 7), (300, 10)]:
        answer = np.zeros(n or 1)
        for name, function in {"sphere": sphere, "a constant": lambda _, answer=answer: answer}.items():
            what = f"{n} points" if n else "one point"
            found[f"a call with {what}, d = {d}, {name}"] = beside(function, n, d)[1]
    for label, budget in RUNS.items():
        with suppress(ImportError):
            found[f"an evaluation of {label}"] = min(run(label, budget) for _ in range(TURNS))
    return found


def before_and_after(other: Path) -> None:
    """Print what both checkouts take, measured by turns in processes of their own, and the median of the ratios."""
    turns: list[list[dict[str, float]]] = []
    for _ in range(TURNS):
        both = []
        for checkout in (other, HERE):
            command = [sys.executable, str(Path(__file__).resolve()), "--json"]
            environment = os.environ | {"PYTHONPATH": str(checkout)}
            both.append(json.loads(subprocess.run(command, check=True, env=environment, stdout=subprocess.PIPE).stdout))
        turns.append(both)
    print(f"{'us beside the function':<60}{'before':>9}{'after':>9}{'ratio':>8}")
    for name in turns[0][0]:
        before, after = (min(both[index][name] for both in turns) for index in range(2))
        ratio = median(both[0][name] / both[1][name] for both in turns)
        print(f"{name:<60}{before:>9.2f}{after:>9.2f}{ratio:>8.1f}")


def peers(d: int) -> None:
    """Print what ioh with a logger and cocoex with an observer take at one point, where they are installed."""
    x = list(np.random.default_rng(1).uniform(-5, 5, (POINTS, d)))
    rows = [each[np.newaxis] for each in x]
    problem = FunctionProblem(sphere, [-5.0] * d, [5.0] * d)
    objective = Objective(problem, ENDLESS, np.random.default_rng(0))
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        with suppress(ImportError):
            import ioh

            def one(point: Any) -> float:
                return float((point * point).sum())

            wrapped = ioh.wrap_problem(one, name="sphere of Python", dimension=d, lb=-5, ub=5)
            compiled = ioh.get_problem("Sphere", 1, d, ioh.ProblemClass.BBOB)
            loggers = [ioh.logger.Analyzer(root=folder, folder_name=name) for name in ("wrapped", "compiled")]
            for each, logger in zip((wrapped, compiled), loggers, strict=True):  # neither keeps its logger alive
                each.attach_logger(logger)
            ours, alone, theirs, theirs_alone, with_sphere = us_a_call(
                (objective, x), (problem.evaluate, rows), (wrapped, x), (one, x), (compiled, x)
            )
            print(f"ioh with its logger, d = {d}, beside a sphere in Python {theirs - theirs_alone:>29.2f}")
            print(f"the objective, in turn with it {ours - alone:>54.2f}")
            print(f"ioh with its logger, d = {d}, with its own compiled sphere {with_sphere:>26.2f}")
        with suppress(ImportError):
            import cocoex

            suite = cocoex.Suite("bbob", "", f"dimensions:{d} function_indices:1 instance_indices:1")
            watched = suite.get_problem(0)  # a loop would free it
            watched.observe_with(cocoex.Observer("bbob", "result_folder: observed"))
            ours, alone, theirs = us_a_call((objective, x), (problem.evaluate, rows), (watched, x))
            print(f"cocoex with its observer, d = {d}, with its own compiled sphere {theirs:>21.2f}")
            print(f"the objective, in turn with it {ours - alone:>54.2f}")


def main() -> None:
    with threadpool_limits(limits=1):
        if sys.argv[1:] == ["--json"]:
            print(json.dumps(measure()))
        elif sys.argv[1:]:
            before_and_after(Path(sys.argv[1]).resolve())
        else:
            print(f"{'us beside the function':<76}{'':>9}")
            for name, took in measure().items():
                print(f"{name:<76}{took:>9.2f}")
            peers(10)


if __name__ == "__main__":
    main()
