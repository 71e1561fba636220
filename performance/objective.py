"""Compare the speed of the compiled objective and of the literal numpy formula in one run on one core.

Both evaluate the same points, which satisfy the constraints, on dataset 12. They run in turn, and the best of several
rounds counts, so that a busy moment of the machine favours neither.
"""

from time import perf_counter

import numpy as np
from _rows import Rows, main, short

from bench import load_problem
from problems.backlash.signature import model

POINTS, LITERAL_POINTS = 300, 30


def measure(quick: bool) -> Rows:
    rounds, repeats = (1, 10) if quick else (9, 200)
    problem = load_problem("signature-12", unit="rpm")
    rng = np.random.default_rng(0)
    points = problem.repair(rng.uniform(problem.lower, problem.upper, (POINTS, problem.dimension)))
    train = {"period": problem.period, "replicas": problem.replicas}
    values = problem.evaluate(points)
    literal = np.array([model.rmse(problem.signal, problem.time, x, **train) for x in points])
    fast_s, literal_s = np.inf, np.inf
    for _ in range(rounds):
        began = perf_counter()
        for _ in range(repeats):
            problem.evaluate(points)
        fast_s = min(fast_s, (perf_counter() - began) / (repeats * POINTS))
        began = perf_counter()
        for x in points[:LITERAL_POINTS]:
            model.rmse(problem.signal, problem.time, x, **train)
        literal_s = min(literal_s, (perf_counter() - began) / LITERAL_POINTS)
    differ = np.abs(values - literal).max()
    value = (
        f"the literal numpy formula takes {literal_s / fast_s:,.0f} times as long: {short(literal_s * 1e3)} ms against "
        f"{short(fast_s * 1e6)} us; values differ by at most {differ:.0e} rpm"
    )
    return [(f"one evaluation of the signature's objective, in batches of {POINTS}", value)]


if __name__ == "__main__":
    main(measure)
