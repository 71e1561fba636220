"""How often ``bench atlas`` calls copies of an implementation different, by simulation and by runs.

    python validation/atlas.py [REPEATS]        # default: 400 simulated atlases of each kind, half as many of runs

A simulated atlas has 5 methods with 3 copies each: 15 pairs, 10 functions and 4 measures, so 600 tests. A copy's trials
are numbers of one distribution; the measures of a trial depend on each other as the stages of one search do. In an
atlas of runs, a copy is the same optimizer with other seeds, on the atlas's own functions. The last column is of a
pair of which one has twice the spread in all measures, with the same medians: these are different, and not copies.
"""

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bench import load_optimizer
from bench.analysis.similarity import STAGES, TRAITS
from bench.atlas.compare import compare
from bench.atlas.runs import MEASURES, PROBLEMS, AtlasRun, Surveyed, measure
from bench.atlas.table import Implementation
from bench.seeds import trial_seed

METHODS, COPIES = 5, 3
RUNS = (("gwo", {"agents": 10}), ("cma-es-fast", {}), ("random-search", {}))
RUN_TRIALS = (8, 15)
BUDGET = 200

Draw = Callable[[np.random.Generator, int], np.ndarray]


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    rng = np.random.default_rng(35)
    print("trials of      number  atlases in which any copy is called different  pairs of unequal spread called so")
    for name, draw in (("continuous", continuous), ("ties", tied), ("heavy tails", heavy), ("two values", binary)):
        for trials in (8, 15, 20):
            wrong = [any_different(copies(rng, draw, trials)) for _ in range(repeats)]
            spread = [any_different(pair(rng, draw, trials)) for _ in range(repeats)]
            print(f"{name:14} {trials:6}  {rate(wrong):>45}  {rate(spread):>33}", flush=True)
    made = [runs(number, max(RUN_TRIALS)) for number in range(repeats // 2)]
    for trials in RUN_TRIALS:
        wrong = [any_different([first(each, trials) for each in found]) for found in made]
        print(f"{'optimizers':14} {trials:6}  {rate(wrong):>45}", flush=True)


def copies(rng: np.random.Generator, draw: Draw, trials: int) -> list[Surveyed]:
    """Return an atlas of copies."""
    return [
        surveyed(f"method {method}", str(copy), {problem: draw(rng, trials) for problem in PROBLEMS})
        for method in range(METHODS)
        for copy in range(COPIES)
    ]


def pair(rng: np.random.Generator, draw: Draw, trials: int) -> list[Surveyed]:
    """Return two implementations of one method, the second of which has twice the spread."""
    return [
        surveyed("method", str(factor), {problem: factor * draw(rng, trials) for problem in PROBLEMS})
        for factor in (1, 2)
    ]


def runs(number: int, trials: int) -> list[Surveyed]:
    """Return an atlas of runs: two copies of each of three optimizers."""
    found = []
    for name, options in RUNS:
        optimizer = load_optimizer(name, **options)
        for copy in ("one", "other"):
            seeds = [trial_seed(number, name, copy, trial) for trial in range(trials)]
            measures = {
                problem: np.array(
                    [measure(optimizer, AtlasRun(problem, BUDGET, each, 10))["measures"] for each in seeds]
                )
                for problem in PROBLEMS
            }
            found.append(surveyed(name, copy, measures))
    return found


def first(found: Surveyed, trials: int) -> Surveyed:
    """Return an implementation with its first trials alone."""
    return replace(found, measures={problem: values[:trials] for problem, values in found.measures.items()})


def surveyed(method: str, label: str, measures: dict[str, np.ndarray]) -> Surveyed:
    """Return an implementation with these measures; its behaviours decide nothing, and are left at 0."""
    behaviours = {problem: np.zeros((len(values), STAGES * len(TRAITS))) for problem, values in measures.items()}
    return Surveyed(Implementation(method, label, label), "", measures, behaviours)


def any_different(found: list[Surveyed]) -> bool:
    """Return whether any pair of the atlas is called different."""
    return bool(compare(found, similar=False).pairs["different"].any())


def continuous(rng: np.random.Generator, trials: int) -> np.ndarray:
    """Return (trials, measures) of which each depends on those before it."""
    return rng.standard_normal((trials, len(MEASURES))).cumsum(axis=1)


def tied(rng: np.random.Generator, trials: int) -> np.ndarray:
    """Return the same, rounded so that most values tie."""
    return continuous(rng, trials).round()


def heavy(rng: np.random.Generator, trials: int) -> np.ndarray:
    """Return one number of a t distribution with 2 degrees of freedom for all measures of a trial."""
    return np.repeat(rng.standard_t(2, (trials, 1)), len(MEASURES), axis=1)


def binary(rng: np.random.Generator, trials: int) -> np.ndarray:
    """Return one of two values for all measures of a trial, as where a search succeeds or ends in a local optimum."""
    return np.repeat(rng.choice([-1.0, 1.0], (trials, 1), p=[0.3, 0.7]), len(MEASURES), axis=1)


def rate(found: list[bool]) -> str:
    """Return a share with its standard error, that of two more cases of either kind: none seen is not none at all."""
    adjusted = (np.sum(found) + 2) / (len(found) + 4)  # Agresti and Coull 1998, The American Statistician 52
    return f"{100 * np.mean(found):.1f}% +- {100 * np.sqrt(adjusted * (1 - adjusted) / (len(found) + 4)):.1f}"


if __name__ == "__main__":
    main()
