"""Measure what a call costs an optimizer that is a program: a request and its answer, beside the sphere, on one core.

The program is a loop in Python that sends one line again and again, so that its own search costs nothing.
"""

import json
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from time import perf_counter

import numpy as np
from _rows import Rows, main, short
from threadpoolctl import threadpool_limits

from bench import BudgetExhausted, FunctionProblem, Objective, load_optimizer

DIMENSION = 10
PROGRAM = """
input()
while True:
    print({line!r}, flush=True)
    input()
"""


def measure(quick: bool) -> Rows:
    rounds, calls = (1, 20) if quick else (7, 2000)
    with threadpool_limits(limits=1), tempfile.TemporaryDirectory() as folder:
        found = {n: us_a_call(Path(folder, "mine.py"), n, calls, rounds) for n in (1, 300)}
    return [
        (f"a call of a program with {n} point{'s' * (n > 1)} of {DIMENSION} coordinates", f"{short(us)} us")
        for n, us in found.items()
    ]


def us_a_call(path: Path, n: int, calls: int, rounds: int) -> float:
    """Return the microseconds a call with n points, without the time in the objective and the start of the program.

    That is the difference of two trials of which one makes a single call; the fastest of each counts.
    """
    points = np.random.default_rng(0).uniform(-5, 5, (n, DIMENSION)).tolist()
    path.write_text(PROGRAM.format(line=json.dumps({"x": points})), encoding="utf-8")
    optimizer = load_optimizer(f"command:'{sys.executable}' '{path}'")
    problem = FunctionProblem(lambda x: (x * x).sum(axis=1), [-5.0] * DIMENSION, [5.0] * DIMENSION, vectorized=True)
    fastest = [np.inf, np.inf]
    for _ in range(rounds):
        for place, budget in enumerate((n, n * (calls + 1))):
            objective = Objective(problem, budget, np.random.default_rng(0))
            began = perf_counter()
            with suppress(BudgetExhausted):
                optimizer.minimize(objective, np.random.default_rng(1))
            fastest[place] = min(fastest[place], perf_counter() - began - objective.objective_s)
    return (fastest[1] - fastest[0]) / calls * 1e6


if __name__ == "__main__":
    main(measure)
