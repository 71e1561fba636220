"""How often intervals of A12 hold the true value, by simulation, with standard errors.

    python validation/intervals.py [STUDIES]        # default: 2,000 a row; some minutes

Intervals of the probability to end lower are in
validation/claims.py.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np
from scipy.stats import norm

from bench.analysis.direction import effects, intervals
from bench.contract.typing import Floats

KINDS = ("normal", "three times the spread", "two basins", "ties at the optimum")
TRIALS = (5, 10, 30)


def main(studies: int) -> None:
    print(f"{studies:,} studies a row; in brackets: standard errors")
    header("interval of A12", *(f"{n} trials" for n in TRIALS))
    for kind in KINDS:
        for true in (0.5, 0.75, 0.95):
            row(f"{kind}, true {true}", [a12_holds(kind, true, n, studies) for n in TRIALS])


def header(*names: str) -> None:
    print("\n" + names[0].ljust(44) + "".join(name.rjust(15) for name in names[1:]))


def row(name: str, held: Sequence[Floats]) -> None:
    """Print shares with their standard errors; the first axis of each of ``held`` are independent studies."""
    means = [own.reshape(len(own), -1).mean(axis=1) for own in held]
    cells = [f"{own.mean():.3f} ({own.std() / len(own) ** 0.5:.3f})" for own in means]
    print(name.ljust(44) + "".join(cell.rjust(15) for cell in cells), flush=True)


def draw(rng: np.random.Generator, kind: str, true: float, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    """Return values of two optimizers of which the first is lower with the chance ``true``."""
    this, other = rng.standard_normal((2, *shape))
    if kind == "normal":
        return this, other + np.sqrt(2) * norm.ppf(true)
    if kind == "three times the spread":
        return this, 3 * other + np.sqrt(10) * norm.ppf(true)
    missed = [rng.random(shape) < chance for chance in (1 - true, true)]  # A12 = 1/2 + the difference / 2
    if kind == "two basins":
        return this / 10 + 5 * missed[0], other / 10 + 5 * missed[1]
    return np.exp(this) * missed[0], np.exp(other) * missed[1]


def a12_holds(kind: str, true: float, trials: int, studies: int) -> Floats:
    low, high = intervals(effects(*draw(np.random.default_rng(1), kind, true, (studies, trials))))
    return np.asarray((low <= true) & (true <= high))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000)
