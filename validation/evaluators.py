"""Time ``bench.Evaluator`` beside the evaluators of BLADE and of LLaMEA, on one candidate and the same problems.

    pip install iohblade llamea, in an environment that has backlash-bench[suites]
    python validation/evaluators.py [--no-sandbox]

BLADE makes an environment for candidates and starts a process of it for each one. LLaMEA leaves the evaluation to its
user; that of its examples runs the candidate in the process of the search, as ``evaluate`` of BLADE's problem does.
The costs are processor seconds of all processes, so that other work on the machine changes little.
"""

import sys
from collections.abc import Callable
from time import perf_counter

import ioh
import numpy as np
from evaluator import ORDINARY, spent
from iohblade.benchmarks.BBOB.bbob_sboxcost import BBOB_SBOX
from iohblade.solution import Solution

import bench

FUNCTIONS, BUDGET, DIMENSION, TIMES = range(1, 11), 2000, 5, 5
SOURCE = ORDINARY[1]


def main() -> None:
    problem = BBOB_SBOX(
        training_instances=[(function, 1) for function in FUNCTIONS],
        dims=[DIMENSION],
        budget_factor=BUDGET // DIMENSION,
        problem_type=ioh.ProblemClass.BBOB,
    )
    problem.dependencies, problem.use_system_site_packages = [], True  # those that are here
    names = [f"bbob-f{function:02}-d{DIMENSION}-i1" for function in FUNCTIONS]
    with bench.Evaluator(names, budget=BUDGET, trials=1, sandbox="--no-sandbox" not in sys.argv) as judge:
        costs = timed(
            {
                "bench.Evaluator": lambda: judge.llamea(solution()).fitness,
                "BLADE, a process a candidate": lambda: problem(solution()).fitness,
                "LLaMEA, in this process": lambda: problem.evaluate(solution()).fitness,
            }
        )
    problem.cleanup()
    own = costs["bench.Evaluator"]
    for name, (wall, cpu) in costs.items():
        ratios = f"{wall / own[0]:.2f} and {cpu / own[1]:.2f} of ours"
        print(f"{name}: {wall:.2f} s, {cpu:.2f} s of processor time; {ratios}")


def solution() -> Solution:
    return Solution(code=SOURCE, name="RandomSearch")


def timed(judges: dict[str, Callable[[], float]]) -> dict[str, tuple[float, float]]:
    """Return the median wall and processor seconds of each judge, one after the other, once all have started."""
    for name, judge in judges.items():
        print(f"{name}: score {judge():.4f}")
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in judges}
    for _ in range(TIMES):
        for name, judge in judges.items():
            began, used = perf_counter(), spent()
            judge()
            found[name].append((perf_counter() - began, spent() - used))
    return {name: tuple(map(float, np.median(each, axis=0))) for name, each in found.items()}


if __name__ == "__main__":
    main()
