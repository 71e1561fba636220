"""Compare the overhead of the swarms here with that of mealpy's classes of the same algorithms, on one core.

Run with ``python performance/against_mealpy.py`` (about two minutes; needs ``pip install mealpy``). Both sides minimise
the same sphere with the same agents and a schedule of the same generations; a run here makes all of them, a run of
mealpy only the first few. The time in the objective is left out on both sides, and the two alternate. mealpy's
dragonflies spend two evaluations an agent and generation, so the ratio is printed by generation and by evaluation.
"""

from statistics import median
from time import perf_counter

import numpy as np
from mealpy import ALO as MEALPY_ALO
from mealpy import DO as MEALPY_DO
from mealpy import GOA as MEALPY_GOA
from mealpy import GWO as MEALPY_GWO
from mealpy import FloatVar
from overhead import AGENTS, DIMENSION, GENERATIONS, overhead
from threadpoolctl import threadpool_limits

from bench import Optimizer
from optimizers.alo import ALO
from optimizers.da import DA
from optimizers.goa import GOA
from optimizers.gwo import GWO

ROUNDS = 5

PAIRS: list[tuple[str, Optimizer, type, int]] = [  # and the number of mealpy's generations in a round
    ("gwo", GWO(agents=AGENTS), MEALPY_GWO.OriginalGWO, 50),
    ("alo", ALO(agents=AGENTS), MEALPY_ALO.OriginalALO, 10),
    ("goa", GOA(agents=AGENTS), MEALPY_GOA.OriginalGOA, 2),
    ("da", DA(agents=AGENTS), MEALPY_DO.OriginalDO, 2),
]


def mealpy_overhead(solver: type, generations: int, seed: int) -> tuple[float, float]:
    """Return the milliseconds of a generation of mealpy outside the objective, and its number of evaluations."""
    durations = []

    def sphere(x: np.ndarray) -> float:
        began = perf_counter()
        value = float((x * x).sum())
        durations.append(perf_counter() - began)
        return value

    model = solver(epoch=GENERATIONS, pop_size=AGENTS)
    model.solve(
        {
            "obj_func": sphere,
            "bounds": FloatVar(lb=[-5.0] * DIMENSION, ub=[5.0] * DIMENSION),
            "minmax": "min",
            "log_to": None,
        },
        termination={"max_epoch": generations},
        seed=seed,
    )
    assert len(model.history.list_epoch_time) == generations
    evaluations = len(durations) // (generations + 1)  # the start population costs as much as a generation
    spent = sum(model.history.list_epoch_time) - sum(durations[-generations * evaluations :])
    return spent / generations * 1e3, evaluations


def main() -> None:
    print(
        f"{AGENTS} agents, d = {DIMENSION}, schedule of {GENERATIONS} generations, one core, median of {ROUNDS} rounds"
    )
    print(f"{'':<6}{'here':>12}{'mealpy':>12}{'ratio':>12}{'ratio':>16}")
    print(f"{'':<6}{'ms/gen.':>12}{'ms/gen.':>12}{'a generation':>12}{'an evaluation':>16}")
    with threadpool_limits(limits=1):
        for label, optimizer, solver, generations in PAIRS:
            overhead(optimizer, seed=0)  # compiles
            here, there = [], []
            for seed in range(1, ROUNDS + 1):
                here.append(overhead(optimizer, seed))
                ms, evaluations = mealpy_overhead(solver, generations, seed)
                there.append(ms)
            ratio = median(b / a for a, b in zip(here, there, strict=True))
            print(
                f"{label:<6}{median(here):>12.3f}{median(there):>12.1f}{ratio:>12.0f}"
                f"{ratio * AGENTS / evaluations:>16.0f}"
            )


if __name__ == "__main__":
    main()
