"""Measure how much more a call of the objective costs than the function that it calls, in one run on one core.

That is the processor time of ``objective(x)`` less that of ``problem.evaluate`` on an equal array. Both are called in
turn, and the fastest of several rounds counts, so that a busy moment of the machine favours neither. Where ioh is
installed, it is measured in the same turns, with its logger, on the same sphere in Python.
"""

import tempfile
from collections.abc import Callable
from contextlib import chdir, suppress
from time import perf_counter, process_time
from typing import Any

import numpy as np
from _rows import Rows, main, short, times
from threadpoolctl import threadpool_limits

from bench import FunctionProblem, Objective
from bench.execution.side_by_side import evaluated

DIMENSION, POINTS = 10, 100
ENDLESS = 10**12  # evaluations


def sphere(x: np.ndarray) -> np.ndarray:
    return (x * x).sum(axis=1)


def single(x: np.ndarray) -> float:
    return float((x * x).sum())


def measure(quick: bool) -> Rows:
    rounds = 2 if quick else 15
    with threadpool_limits(limits=1):
        rows = [beside(n, rounds) for n in (1, 30, 300)]
        rows.append(side_by_side(20 if quick else 2000))
        with suppress(ImportError):
            rows.append(against_ioh(rounds))
    return rows


def us_a_call(rounds: int, *timed: tuple[Callable[[Any], Any], list[Any]]) -> list[float]:
    """Return the microseconds a call of each function, on one of its arguments after the other."""
    repeats, fastest = [], [np.inf] * len(timed)
    for function, arguments in timed:
        began = process_time()
        for x in arguments:
            function(x)
        repeats.append(max(1, round(0.02 / (process_time() - began))))
    for _ in range(rounds):
        for index, (function, arguments) in enumerate(timed):
            began = process_time()
            for _ in range(repeats[index]):
                for x in arguments:
                    function(x)
            took = (process_time() - began) / repeats[index] / len(arguments)
            fastest[index] = min(fastest[index], took * 1e6)
    return fastest


def sphere_and_points(n: int) -> tuple[FunctionProblem, Objective, list[np.ndarray]]:
    problem = FunctionProblem(sphere, [-5.0] * DIMENSION, [5.0] * DIMENSION, vectorized=True)
    objective = Objective(problem, ENDLESS, np.random.default_rng(0))
    return problem, objective, list(np.random.default_rng(1).uniform(-5, 5, (POINTS, n, DIMENSION)))


def beside(n: int, rounds: int) -> tuple[str, str]:
    problem, objective, batches = sphere_and_points(n)
    alone, whole = us_a_call(rounds, (problem.evaluate, batches), (objective, batches))
    what = f"{n} points" if n > 1 else "one point"
    value = f"{short(whole - alone)} us, {times((whole - alone) / alone)} the sphere itself"
    return f"a call of the objective with {what} of {DIMENSION} coordinates, less a sphere in numpy", value


def side_by_side(calls: int) -> tuple[str, str]:
    problem, _, batches = sphere_and_points(8)
    with evaluated(problem, 2) as beside:
        took = []
        for _ in range(calls // len(batches) + 1):
            for x in batches:
                began = perf_counter()
                beside.evaluate(x)
                took.append(perf_counter() - began)
    value = f"{short(float(np.median(took)) / 8 * 1e6)} us a point, whatever its evaluation takes"
    return "a call of 8 points with `parallel = 2`, by processes of the problem", value


def against_ioh(rounds: int) -> tuple[str, str]:
    import ioh

    problem, objective, batches = sphere_and_points(1)
    points = [batch[0] for batch in batches]
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        theirs = ioh.wrap_problem(single, name="sphere of Python", dimension=DIMENSION, lb=-5, ub=5)
        logger = ioh.logger.Analyzer(root=folder, folder_name="log")  # ioh does not keep it alive
        theirs.attach_logger(logger)
        whole, alone, ioh_whole, ioh_alone = us_a_call(
            rounds, (objective, points), (problem.evaluate, batches), (theirs, points), (single, points)
        )
    ours, other = whole - alone, ioh_whole - ioh_alone
    value = f"{times(ours / other)} ioh's: {short(ours)} us and {short(other)} us"
    return "a call with a single point, less the sphere, against ioh with its logger", value


if __name__ == "__main__":
    main(measure)
