"""Compare the speed of the compiled objective and of the literal numpy formula in one run on one core.

Run with ``python performance/objective.py``. Both evaluate the same 300 points, which satisfy the constraints, on
dataset 12. They run in turn, and the best of several rounds counts, so that a busy moment of the machine favours
neither.
"""

from time import perf_counter

import numpy as np

from bench import load_problem
from problems.backlash.signature import model

POINTS, ROUNDS, REPEATS = 300, 9, 200
LITERAL_POINTS = 30


def main() -> None:
    problem = load_problem("signature-12", unit="rpm")
    rng = np.random.default_rng(0)
    points = problem.repair(rng.uniform(problem.lower, problem.upper, (POINTS, problem.dimension)))
    train = {"period": problem.period, "replicas": problem.replicas}
    values = problem.evaluate(points)
    literal = np.array([model.rmse(problem.signal, problem.time, x, **train) for x in points])
    fast_s, literal_s = np.inf, np.inf
    for _ in range(ROUNDS):
        began = perf_counter()
        for _ in range(REPEATS):
            problem.evaluate(points)
        fast_s = min(fast_s, (perf_counter() - began) / (REPEATS * POINTS))
        began = perf_counter()
        for x in points[:LITERAL_POINTS]:
            model.rmse(problem.signal, problem.time, x, **train)
        literal_s = min(literal_s, (perf_counter() - began) / LITERAL_POINTS)
    print(f"literal numpy formula {literal_s * 1e3:8.3f} ms an evaluation")
    print(f"compiled objective    {fast_s * 1e6:8.3f} us an evaluation, in batches of {POINTS}")
    print(f"ratio                 {literal_s / fast_s:8.0f}")
    print(f"largest difference    {np.abs(values - literal).max():8.1e} rpm")


if __name__ == "__main__":
    main()
