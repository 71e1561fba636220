"""Predicted and real times to a target with several workers, on an objective that sleeps.

    python validation/parallel.py [SECONDS]           # of an evaluation; default: 0.4, ten minutes

Each optimizer first makes serial runs on a sphere that costs nothing. From their evaluations and calls,
:func:`bench.analysis.parallel_times` predicts the time to a target. The same runs are then made on a sphere that sleeps
at each point, with that many points in parallel, up to the evaluation that reaches the target (or to the budget, where
none does). The predicted time is that of a run alone, so no restarts are in it; own times come from the serial runs.
"""

import sys
import time

import numpy as np
import pandas as pd

from bench import FunctionProblem, analysis, load_optimizer, solve

OPTIMIZERS = {
    "cma-es": {}, "gwo": {"agents": 30}, "pymoo:DE": {"agents": 25}, "bipop-cma-es": {}, "random-search": {},
    "scipy:differential_evolution": {"updating": "deferred"}, "nevergrad:PSO": {},
}  # fmt: skip
WORKERS = (1, 3, 8, 16)
SEEDS = (1,)
AGAIN = 3  # real runs with several workers, of which the fastest counts: the machine may be busy
BUDGET, TARGET, DIMENSION = 180, 0.2, 5


def sphere(pause: float) -> FunctionProblem:
    def evaluate(x: np.ndarray) -> np.ndarray:
        time.sleep(pause * len(x))
        return ((x - 0.3) ** 2).sum(axis=1)

    return FunctionProblem(evaluate, [-1.0] * DIMENSION, [1.0] * DIMENSION, name="sphere")


def main() -> None:
    pause = float(sys.argv[1]) if len(sys.argv) > 1 else 0.4
    print(f"{'':30} seed evals calls", *(f"{f'{p} workers':>22}" for p in WORKERS))
    errors = []
    for name, options in OPTIMIZERS.items():
        for seed in SEEDS:
            optimizer = load_optimizer(name, **options)
            solve(sphere(0.0), optimizer, budget=BUDGET, seed=0)  # what is compiled or imported at the first run
            free = solve(sphere(0.0), optimizer, budget=BUDGET, seed=seed)
            reached = free.trace.evaluations[free.trace.values <= TARGET]
            spent = int(reached[0]) if len(reached) else free.nfev
            row = {"problem": "sphere", "optimizer": name, "trial": 0}
            hits = pd.DataFrame([row | {"tau": 1.0, "target": TARGET, "evaluations": float(spent), "spent": free.nfev}])
            about = {key: getattr(free, key) for key in ("nfev", "calls", "largest_call", "wall_s", "objective_s")}
            frame = pd.DataFrame([row | about | {"status": "ok"}])
            predicted = analysis.parallel_times(hits, frame, WORKERS, [pause]).set_index("workers")["time"]
            cells = []
            for p in WORKERS:
                runs = range(1 if p == 1 else AGAIN)
                real = min(solve(sphere(pause), optimizer, budget=spent, seed=seed, parallel=p).wall_s for _ in runs)
                errors.append(predicted[p] / real - 1)
                cells.append(f"{predicted[p]:6.2f} {real:6.2f} {100 * errors[-1]:+6.1f} %")
            print(f"{name:30} {seed:4} {spent:5} {free.calls:5}", *(f"{cell:>22}" for cell in cells), flush=True)
    shares = np.abs(errors)
    print(f"{len(errors)} pairs: largest difference {100 * shares.max():.1f} %, mean {100 * np.mean(errors):+.1f} %")


if __name__ == "__main__":
    main()
