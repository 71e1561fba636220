"""What the variants of GWO, ALO and GOA change: final bests of the default beside those of the other.

    python benchmarks/variants.py        # about three minutes

Five functions with d = 7, 30 agents, 200 generations, 200 seeds each. p is of the exact two-sample Kolmogorov-Smirnov
test, A12 the chance that the variant's run ends lower than the default's, ties counted by half.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.stats import ks_2samp, mannwhitneyu

from bench import Optimizer, solve
from optimizers.alo import ALO
from optimizers.goa import GOA
from optimizers.gwo import GWO

RUNS = 200
PAIRS: list[tuple[Optimizer, Optimizer]] = [
    (GWO(), GWO(variant="cascade")),
    (ALO(), ALO(variant="paper")),
    (GOA(), GOA(variant="full-distance")),
]


def main() -> None:
    sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "optimizers"))
    from functions import AGENTS, GENERATIONS, PROBLEMS, D  # the very functions that the tests compare on

    def final_bests(optimizer, problem, first):
        runs = range(first, first + RUNS)
        return np.array([solve(problem, optimizer, budget=AGENTS * GENERATIONS, seed=seed).fun for seed in runs])

    print(f"final bests, median [5 %, 95 %]: d = {D}, {AGENTS} agents, {GENERATIONS} generations, {RUNS} seeds each")
    print(f"{'':<18}{'function':<12}{'default':<28}{'variant':<28}{'p (KS)':<10}A12")
    for default, variant in PAIRS:
        for name, problem in PROBLEMS.items():
            a, b = final_bests(default, problem, 0), final_bests(variant, problem, RUNS)
            p = ks_2samp(a, b, method="exact").pvalue
            a12 = mannwhitneyu(a, b).statistic / RUNS**2
            label = f"{type(variant).__name__} {variant.variant}"
            print(f"{label:<18}{name:<12}{spell(a):<28}{spell(b):<28}{p:<10.1g}{a12:.2f}", flush=True)


def spell(bests: np.ndarray) -> str:
    low, middle, high = np.quantile(bests, [0.05, 0.5, 0.95])
    return f"{middle:.2g} [{low:.2g}, {high:.2g}]"


if __name__ == "__main__":
    main()
