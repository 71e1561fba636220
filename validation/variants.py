"""Compare the final bests of each built-in's default with those of another version of its algorithm.

    python validation/variants.py           # the variants of GWO, ALO and GOA: about three minutes
    python validation/variants.py mealpy    # mealpy's classes of the same names: about fifteen minutes; needs mealpy

Five functions with d = 7, 30 agents and 200 generations' evaluations (6,000). p is of the exact two-sample
Kolmogorov-Smirnov test; A12 is the chance that a run of the other version ends lower, ties counted by half.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.stats import ks_2samp, mannwhitneyu

from bench import load_optimizer, solve

VARIANTS = [("gwo", "cascade"), ("alo", "paper"), ("goa", "full-distance")]
NAMESAKES = [("gwo", "mealpy:OriginalGWO"), ("alo", "mealpy:OriginalALO"), ("goa", "mealpy:OriginalGOA"),
             ("da", "mealpy:OriginalDO")]  # fmt: skip


def main() -> None:
    sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "optimizers"))
    from functions import AGENTS, GENERATIONS, PROBLEMS, D  # the functions of the tests

    def final_bests(optimizer, problem, first):
        runs = range(first, first + trials)
        return np.array([solve(problem, optimizer, budget=AGENTS * GENERATIONS, seed=seed).fun for seed in runs])

    if sys.argv[1:] == ["mealpy"]:
        trials = 30
        pairs = [(load_optimizer(ours), load_optimizer(other, agents=AGENTS), other) for ours, other in NAMESAKES]
    else:
        trials = 200
        pairs = [
            (load_optimizer(name), load_optimizer(name, variant=variant), f"{name} {variant}")
            for name, variant in VARIANTS
        ]
    print(f"final bests, median [5%, 95%]: d = {D}, {AGENTS} agents, {GENERATIONS} generations, {trials} seeds each")
    print(f"{'':<20}{'function':<12}{'default':<28}{'the other':<28}{'p (KS)':<10}A12")
    for default, variant, label in pairs:
        for name, problem in PROBLEMS.items():
            a, b = final_bests(default, problem, 0), final_bests(variant, problem, trials)
            p = ks_2samp(a, b, method="exact").pvalue
            a12 = mannwhitneyu(a, b).statistic / trials**2
            print(f"{label:<20}{name:<12}{spell(a):<28}{spell(b):<28}{p:<10.1g}{a12:.2f}", flush=True)


def spell(bests: np.ndarray) -> str:
    low, middle, high = np.quantile(bests, [0.05, 0.5, 0.95])
    return f"{middle:.2g} [{low:.2g}, {high:.2g}]"


if __name__ == "__main__":
    main()
