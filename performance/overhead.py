"""Measure the overhead of each optimizer: the time of a generation outside the objective function, on one core.

The optimizers take turns, so that a busy moment of the machine favours none. To measure another, add it to OPTIMIZERS.
"""

from contextlib import suppress
from statistics import median
from time import perf_counter

import numpy as np
from _rows import Rows, main, short, times
from threadpoolctl import threadpool_limits

from bench import BudgetExhausted, FunctionProblem, Optimizer, load_optimizer
from bench.contract.objective import Objective

AGENTS, DIMENSION = 300, 7
GENERATIONS = 200

OPTIMIZERS = {
    "random-search": {}, "gwo": {}, "da": {}, "alo": {}, "goa": {},
    "cma-es": {"handling": "box", "start": "midpoint"}, "cma-es-fast": {"handling": "box", "start": "midpoint"},
}  # fmt: skip


def measure(quick: bool) -> Rows:
    runs, generations = (1, 5) if quick else (7, GENERATIONS)
    optimizers = {name: load_optimizer(name, agents=AGENTS, **options) for name, options in OPTIMIZERS.items()}
    with threadpool_limits(limits=1):
        found = [
            {name: overhead(optimizer, seed, generations) for name, optimizer in optimizers.items()}
            for seed in range(runs + 1)
        ][1:]  # the first round compiles
    ms = {name: median(turn[name] for turn in found) for name in OPTIMIZERS}
    rows = []
    for name in OPTIMIZERS:
        ratio = median(turn[name] / turn["random-search"] for turn in found)
        beside = "" if name == "random-search" else f", {times(ratio)} random-search's"
        rows.append(
            (f"own time of a generation of {name}, {AGENTS} agents, d = {DIMENSION}", short(ms[name]) + " ms" + beside)
        )
    ratio = median(turn["cma-es"] / turn["cma-es-fast"] for turn in found)
    return [*rows, ("the same of cma-es against its compiled twin cma-es-fast", times(ratio))]


def overhead(optimizer: Optimizer, seed: int, generations: int = GENERATIONS) -> float:
    """Return the milliseconds of a generation outside the objective, in a run on a sphere."""
    problem = FunctionProblem(lambda x: (x * x).sum(axis=1), [-5.0] * DIMENSION, [5.0] * DIMENSION, vectorized=True)
    start, search = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(2))
    objective = Objective(problem, AGENTS * generations, start)
    began = perf_counter()
    with suppress(BudgetExhausted):
        optimizer.minimize(objective, search)
    return (perf_counter() - began - objective.objective_s) / (objective.nfev / AGENTS) * 1e3


if __name__ == "__main__":
    main(measure)
