"""How often a table of running times has a star where there is no difference, by simulation.

    python validation/other_claims.py [STUDIES]     # default: 300 studies a row

Identical optimizers; the time to each target is lognormal and increases with the target, and a trial ends by chance on
the way. "grid": times are multiples of a population of 300.
"""

import sys
from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

from bench.analysis.running_time import separably_fastest

BUDGET = 10_000


def main() -> None:
    studies = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    print(f"{'a star':62} share of {studies} studies (standard error)", flush=True)
    for label, claims in stars():
        rng = np.random.default_rng(43)
        share = np.mean([claims(rng) for _ in range(studies)])
        error = np.sqrt(max(share * (1 - share), 1 / studies / 4) / studies)
        print(f"{label:62} {share:.3f} ({error:.3f})", flush=True)


def stars() -> Iterator[tuple[str, Callable[[np.random.Generator], bool]]]:
    designs = [(2, 24, 8, 15), (5, 24, 8, 15), (2, 6, 8, 30), (2, 24, 2, 15)]
    for k, functions, targets, n in designs:
        for grid in (False, True):
            label = f"{k} optimizers, {functions} functions, {targets} targets, {n} trials{', grid' if grid else ''}"
            yield label, lambda rng, design=(k, functions, targets, n, grid): star(rng, *design)


def star(rng: np.random.Generator, k: int, functions: int, targets: int, n: int, grid: bool) -> bool:
    """Return whether a table of identical optimizers has a star."""
    shape = functions, k, n, targets
    times = np.cumsum(rng.lognormal(5.0, 1.0, shape), axis=-1)
    times = 300 * np.ceil(times / 300) if grid else times
    left = rng.random((functions, 1, 1, 1)) ** 0.2  # the chance to go on to the next target
    reached = np.logical_and.accumulate(rng.random(shape) < left, axis=-1)
    index = pd.MultiIndex.from_product(map(range, shape), names=["problem", "optimizer", "trial", "tau"])
    table = pd.DataFrame({"evaluations": np.where(reached, times, np.inf).ravel()}, index).reset_index()
    table["optimizer"] = table["optimizer"].map("o{}".format)
    return len(separably_fastest(table.assign(target=table["tau"], spent=BUDGET))) > 0


if __name__ == "__main__":
    main()
