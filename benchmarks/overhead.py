"""Overhead per generation of each optimizer: what a run takes beside its objective function.

Run with ``python benchmarks/overhead.py``. To measure another optimizer, add its pair to OPTIMIZERS.
"""

from contextlib import suppress
from statistics import median
from time import perf_counter

import numpy as np

from bench import BudgetExhausted, FunctionProblem, Optimizer
from bench.objective import Objective
from optimizers.alo import ALO
from optimizers.cma_es import CMAES
from optimizers.da import DA
from optimizers.goa import GOA
from optimizers.gwo import GWO
from optimizers.random_search import RandomSearch

AGENTS, GENERATIONS, DIMENSION, RUNS = 300, 200, 7, 7

OPTIMIZERS: list[tuple[str, Optimizer]] = [
    ("random-search", RandomSearch(agents=AGENTS)),
    ("gwo", GWO(agents=AGENTS)),
    ("da", DA(agents=AGENTS)),
    ("alo", ALO(agents=AGENTS)),
    ("goa", GOA(agents=AGENTS)),
    ("cma-es", CMAES(agents=AGENTS, handling="box", start="midpoint")),
]


def overhead(optimizer: Optimizer, seed: int) -> float:
    """Return the milliseconds a generation takes beside the objective, in a run of at most GENERATIONS on a sphere."""
    problem = FunctionProblem(lambda x: (x * x).sum(axis=1), [-5.0] * DIMENSION, [5.0] * DIMENSION)
    start, search = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(2))
    objective = Objective(problem, AGENTS * GENERATIONS, start)
    began = perf_counter()
    with suppress(BudgetExhausted):
        optimizer.minimize(objective, search)
    return (perf_counter() - began - objective.seconds) / (objective.evaluations / AGENTS) * 1e3


def main() -> None:
    print(f"{AGENTS} agents, {GENERATIONS} generations, d = {DIMENSION}, one core, median of {RUNS} runs")
    print(f"{'optimizer':<16}{'ms a generation':>16}")
    for label, optimizer in OPTIMIZERS:
        overhead(optimizer, seed=0)  # the first run compiles
        ms = median(overhead(optimizer, seed) for seed in range(1, RUNS + 1))
        print(f"{label:<16}{ms:>16.3f}")


if __name__ == "__main__":
    main()
