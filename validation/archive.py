"""Compare the running times of an optimizer on bbob with archived runs of an algorithm from COCO's data archive.

    python validation/archive.py ARCHIVE.json [--functions 1 15] [--dimensions 5 10]
    python validation/archive.py ARCHIVE.json --optimizer bipop-cma-es --options '{"variant": "pycma"}'

ARCHIVE.json holds one algorithm: ``{NAME: {"f15-d5": {"evaluations_to_1e-8": [n or null, …], "evaluations": [n, …]},
…}}``, by function and dimension the evaluations of each run until f - f_opt <= 1e-8, and all its evaluations.
Functions and dimensions that it lacks are left out.

As in BBOB 2009, instances 1 to 5 are run three times each. A run ends at the target, or after twice the evaluations of
the longest archived run (``--limit``), 10,000 d at least. Each line shows both expected running times (ERT), their
ratio, the runs that reached the target, and p of the exact two-sample Kolmogorov-Smirnov test of the running times; a
run that missed the target counts as longer than all that reached it. BIPOP-CMA-ES takes about half an hour for the odd
functions in 5-D and 10-D, most of it for f3 and f19.
"""

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import ks_2samp

from bench import Optimizer, Problem, load_optimizer, load_problem, solve
from bench.contract.typing import Floats

PRECISION = 1e-8
INSTANCES = [1, 2, 3, 4, 5] * 3
FACTOR = 2.0  # a ratio of ERTs between 1 / FACTOR and FACTOR is called the same


@dataclass(frozen=True)
class Runs:
    """The runs of one algorithm on one function: evaluations of each, and whether it ``reached`` the target."""

    evaluations: Sequence[int]
    reached: Sequence[bool]

    @property
    def ert(self) -> float:
        """The evaluations of all runs by the number of those that reached the target; infinite where none did."""
        return sum(self.evaluations) / sum(self.reached) if any(self.reached) else math.inf

    @property
    def times(self) -> Floats:
        """The (n,) running times, infinite where the target was missed."""
        return np.where(self.reached, self.evaluations, math.inf)


class Reached(BaseException):
    """Raised by the problem at the target; no ``except Exception`` of an optimizer catches it."""


class Target(Problem):
    """A problem that ends the run at the first point of the box within PRECISION of the optimum."""

    def __init__(self, problem: Problem) -> None:
        if problem.optimum is None:
            raise ValueError(f"problem {problem.name!r} has no known optimum")
        self.problem, self.name, self.variables = problem, problem.name, problem.variables
        self.lower, self.upper, self.optimum = problem.lower, problem.upper, problem.optimum
        self.target = problem.optimum + PRECISION
        self.evaluations = 0

    def evaluate(self, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points; raises Reached at the target."""
        values = self.problem.evaluate(x)
        hits = np.flatnonzero((values <= self.target) & ((x >= self.lower) & (x <= self.upper)).all(axis=1))
        if len(hits):
            self.evaluations += int(hits[0]) + 1
            raise Reached
        self.evaluations += len(x)
        return values


def archived(path: Path) -> dict[tuple[int, int], tuple[Runs, int]]:
    """Return the archived runs, and the evaluations of the longest, by function and dimension."""
    (cells,) = json.loads(path.read_text(encoding="utf-8")).values()
    found = {}
    for name, cell in cells.items():
        function, dimension = (int(part[1:]) for part in name.split("-"))
        pairs = list(zip(cell["evaluations_to_1e-8"], cell["evaluations"], strict=True))
        runs = Runs([made if hit is None else hit for hit, made in pairs], [hit is not None for hit, _ in pairs])
        found[function, dimension] = runs, max(cell["evaluations"])
    return found


def measured(optimizer: Optimizer, function: int, dimension: int, limit: int) -> Runs:
    """Return our runs, each of at most ``limit`` evaluations."""
    evaluations, reached = [], []
    for seed, instance in enumerate(INSTANCES):
        problem = Target(load_problem(f"bbob-f{function:02d}-d{dimension}-i{instance}"))
        try:
            solve(problem, optimizer, budget=limit, seed=seed)
            reached.append(False)
        except Reached:
            reached.append(True)
        evaluations.append(problem.evaluations)
    return Runs(evaluations, reached)


def p_same(a: Runs, b: Runs) -> float:
    """Return p of the exact Kolmogorov-Smirnov test of two samples of running times."""
    finite = max([*a.evaluations, *b.evaluations])
    first, second = (np.minimum(runs.times, 2 * finite) for runs in (a, b))
    return float(ks_2samp(first, second, method="exact").pvalue)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("archive", type=Path)
    parser.add_argument("--optimizer", default="bipop-cma-es")
    parser.add_argument("--options", type=json.loads, default={}, help="the optimizer's, as JSON")
    parser.add_argument("--functions", type=int, nargs="+", default=range(1, 25))
    parser.add_argument("--dimensions", type=int, nargs="+", default=[5, 10])
    parser.add_argument("--limit", type=float, default=2.0, help="of the evaluations of the longest archived run")
    options = parser.parse_args()
    optimizer = load_optimizer(options.optimizer, **options.options)
    print(f"{options.optimizer} beside {options.archive.name}: {len(INSTANCES)} runs, target {PRECISION:g}")
    print(f"{'d':>3}{'f':>4}{'ERT, ours':>14}{'archived':>14}{'ratio':>8}{'reached':>10}{'archived':>10}{'p (KS)':>9}")
    known = archived(options.archive)
    for dimension in options.dimensions:
        same = counted = 0
        for function in options.functions:
            if (function, dimension) not in known:
                continue
            theirs, longest = known[function, dimension]
            ours = measured(optimizer, function, dimension, max(int(options.limit * longest), 10_000 * dimension))
            # where neither reached the target, there is nothing to compare
            ratio = ours.ert / theirs.ert if any(theirs.reached) else math.nan
            counted += not math.isnan(ratio)
            same += 1 / FACTOR <= ratio <= FACTOR
            reached = [f"{sum(runs.reached)}/{len(runs.reached)}" for runs in (ours, theirs)]
            print(
                f"{dimension:>3}{function:>4}{ours.ert:>14,.0f}{theirs.ert:>14,.0f}{ratio:>8.2f}"
                f"{reached[0]:>10}{reached[1]:>10}{p_same(ours, theirs):>9.2g}",
                flush=True,
            )
        print(f"{dimension}-D: the ratio is within 1/{FACTOR:g} and {FACTOR:g} on {same} of {counted} functions")


if __name__ == "__main__":
    main()
