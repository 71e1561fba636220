"""Compare loops over bbob through the objective with the same loops over cocoex and its observer, on one core.

Both sides evaluate the same points: random ones, one per call or in batches, and those of a differential evolution in
Python (Storn and Price 1997), one per call. cocoex takes no batches. The sides take turns, and processor time counts:
the fastest of several rounds of each function, summed over 24 functions in 2, 5 and 10 dimensions.
"""

import tempfile
from collections.abc import Callable, Iterable
from contextlib import chdir
from functools import partial
from time import process_time

import cocoex
import numpy as np
from _rows import Rows, main, short, times
from threadpoolctl import threadpool_limits

from bench import Objective, load_problem

BATCH, AGENTS = 250, 20
DIMENSIONS = 2, 5, 10
ENDLESS = 10**12  # evaluations


def measure(quick: bool) -> Rows:
    rounds, evaluations, functions = (1, 500, range(1, 3)) if quick else (7, 2000, range(1, 25))
    cocoex.log_level("warning")
    with threadpool_limits(limits=1), tempfile.TemporaryDirectory() as folder, chdir(folder):
        cases = [loops(function, dimension, evaluations) for dimension in DIMENSIONS for function in functions]
        took = np.array([[[seconds(loop) for loop in timed] for timed, _ in cases] for _ in range(rounds)])
    fastest = took.min(axis=0)
    single, batches, theirs, search, their_search = fastest.mean(axis=0) / evaluations * 1e6
    rows = [
        ("random points one per call, against cocoex with its observer", single, theirs),
        (f"random points in batches of {BATCH}, against cocoex with its observer, one per call", batches, theirs),
        (
            "a differential evolution in Python, one point per call, against cocoex with its observer",
            search,
            their_search,
        ),
    ]
    return [
        (f"bbob, {what}", f"{times(here / there)} as long: {short(here)} us and {short(there)} us a point")
        for what, here, there in rows
    ]


def loops(function: int, dimension: int, evaluations: int) -> tuple[list[Callable[[], None]], object]:
    """Return what is timed: points one per call and in batches here, points there, the search here and there.

    What comes with them must live as long.
    """
    problem = load_problem(f"bbob-f{function:02d}-d{dimension}-i1")
    objective = Objective(problem, ENDLESS, np.random.default_rng(0))
    suite = cocoex.Suite("bbob", "instances: 1", f"dimensions: {dimension} function_indices: {function}")
    observer = cocoex.Observer("bbob", "result_folder: log")
    theirs = suite[0]
    theirs.observe_with(observer)
    points = np.random.default_rng(1).uniform(problem.lower, problem.upper, (evaluations, dimension))
    single, batches = list(points), np.array_split(points, evaluations // BATCH)
    return [
        partial(each, objective, single),
        partial(each, objective, batches),
        partial(each, theirs, single),
        partial(evolve, objective, problem.lower, problem.upper, evaluations),
        partial(evolve, theirs, problem.lower, problem.upper, evaluations),
    ], (suite, observer)


def seconds(loop: Callable[[], None]) -> float:
    """Return the processor seconds of a loop."""
    began = process_time()
    loop()
    return process_time() - began


def each(function: Callable[[np.ndarray], object], arguments: Iterable[np.ndarray]) -> None:
    for x in arguments:
        function(x)


def evolve(function: Callable[[np.ndarray], float], lower: np.ndarray, upper: np.ndarray, evaluations: int) -> None:
    """Minimise by differential evolution, "rand/1/bin" with F = 0.5 and CR = 0.9."""
    rng = np.random.default_rng(2)
    agents = rng.uniform(lower, upper, (AGENTS, len(lower)))
    values = [function(x) for x in agents]
    for evaluation in range(AGENTS, evaluations):
        own = evaluation % AGENTS
        first, second, third = agents[rng.integers(AGENTS, size=3)]  # they may coincide, which changes no duration
        crossed = rng.random(len(lower)) < 0.9
        crossed[rng.integers(len(lower))] = True
        x = np.where(crossed, first + 0.5 * (second - third), agents[own])
        x = np.minimum(np.maximum(x, lower), upper)
        value = function(x)
        if value <= values[own]:
            agents[own], values[own] = x, value


if __name__ == "__main__":
    main(measure)
