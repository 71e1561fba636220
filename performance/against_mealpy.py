"""Compare the overhead of the swarms here with that of mealpy's classes of the same algorithms, on one core.

Both sides minimise the same sphere with the same agents and a schedule of the same generations; a run here makes all of
them, a run of mealpy only the first few. The time in the objective is left out on both sides, and the two alternate.
mealpy's dragonflies spend two evaluations an agent and generation, so the ratio is that of an evaluation.
"""

from statistics import median
from time import perf_counter

import numpy as np
from _rows import Rows, main, times
from mealpy import ALO, DO, GOA, GWO, FloatVar
from overhead import AGENTS, DIMENSION, GENERATIONS, overhead
from threadpoolctl import threadpool_limits

from bench import load_optimizer

PAIRS = [  # with the number of mealpy's generations in a round
    ("gwo", GWO.OriginalGWO, 50), ("alo", ALO.OriginalALO, 10), ("goa", GOA.OriginalGOA, 2), ("da", DO.OriginalDO, 2),
]  # fmt: skip


def measure(quick: bool) -> Rows:
    rounds = 1 if quick else 3
    rows = []
    with threadpool_limits(limits=1):
        for name, solver, generations in PAIRS:
            optimizer = load_optimizer(name, agents=AGENTS)
            overhead(optimizer, seed=0)  # compiles
            ratios = []
            for seed in range(1, rounds + 1):
                here = overhead(optimizer, seed) / AGENTS
                there, evaluations = mealpy_overhead(solver, 1 if quick else generations, seed)
                ratios.append(there / evaluations / here)
            rows.append((f"own time an evaluation of mealpy's {solver.__name__} against {name}", times(median(ratios))))
    return rows


def mealpy_overhead(solver: type, generations: int, seed: int) -> tuple[float, int]:
    """Return the milliseconds of a generation of mealpy outside the objective, and its number of evaluations."""
    durations = []

    def sphere(x: np.ndarray) -> float:
        began = perf_counter()
        value = float((x * x).sum())
        durations.append(perf_counter() - began)
        return value

    box = FloatVar(lb=[-5.0] * DIMENSION, ub=[5.0] * DIMENSION)
    problem = {"obj_func": sphere, "bounds": box, "minmax": "min", "log_to": None}
    model = solver(epoch=GENERATIONS, pop_size=AGENTS)
    model.solve(problem, termination={"max_epoch": generations}, seed=seed)
    assert len(model.history.list_epoch_time) == generations
    evaluations = len(durations) // (generations + 1)  # the start population costs as much as a generation
    spent = sum(model.history.list_epoch_time) - sum(durations[-generations * evaluations :])
    return spent / generations * 1e3, evaluations


if __name__ == "__main__":
    main(measure)
