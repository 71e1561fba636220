"""Measure the overhead of each optimizer: the time of a generation outside the objective function.

Run with ``python performance/overhead.py``. To measure another optimizer, add its pair to OPTIMIZERS.
"""

from contextlib import suppress
from statistics import median
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from bench import BudgetExhausted, FunctionProblem, Optimizer
from bench.objective import Objective
from optimizers.alo import ALO
from optimizers.cma_es import CMAES
from optimizers.cma_es_fast import CMAESFast
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
    ("cma-es-fast", CMAESFast(agents=AGENTS, handling="box", start="midpoint")),
]

DEFAULT_AGENTS = CMAES().population(DIMENSION)


def overhead(
    optimizer: Optimizer, seed: int, agents: int = AGENTS, dimension: int = DIMENSION, generations: int = GENERATIONS
) -> float:
    """Return the milliseconds of a generation outside the objective, in a run on a sphere."""
    problem = FunctionProblem(lambda x: (x * x).sum(axis=1), [-5.0] * dimension, [5.0] * dimension)
    start, search = (np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(2))
    objective = Objective(problem, agents * generations, start)
    began = perf_counter()
    with suppress(BudgetExhausted):
        optimizer.minimize(objective, search)
    return (perf_counter() - began - objective.seconds) / (objective.evaluations / agents) * 1e3


def cma_es_against_its_compiled_form(agents: int) -> tuple[float, float, float]:
    """Return the milliseconds a generation of cma-es and of cma-es-fast, and their ratio, each a median of RUNS.

    The two alternate, so that a busy moment of the machine slows both.
    """
    both = [form(agents=agents, handling="box", start="midpoint") for form in (CMAES, CMAESFast)]
    rounds = [[overhead(optimizer, seed, agents) for optimizer in both] for seed in range(RUNS + 1)]
    slow, fast = zip(*rounds[1:], strict=True)  # the first round compiles
    return median(slow), median(fast), median(a / b for a, b in zip(slow, fast, strict=True))


def main() -> None:
    print(f"{AGENTS} agents, {GENERATIONS} generations, d = {DIMENSION}, one core, median of {RUNS} runs")
    print(f"{'optimizer':<16}{'ms a generation':>16}")
    with threadpool_limits(limits=1):
        for label, optimizer in OPTIMIZERS:
            overhead(optimizer, seed=0)  # the first run compiles
            ms = median(overhead(optimizer, seed) for seed in range(1, RUNS + 1))
            print(f"{label:<16}{ms:>16.3f}")
        for agents in (AGENTS, DEFAULT_AGENTS):
            slow, fast, ratio = cma_es_against_its_compiled_form(agents)
            print(f"{agents} agents: cma-es {slow:.3f} ms, cma-es-fast {fast:.3f} ms, {ratio:.1f} times")


if __name__ == "__main__":
    main()
