"""How often ``bench similar`` calls identical optimizers different, and how often others, by simulation.

    python validation/similar.py [REPEATS]        # default: 400 comparisons of each kind

An optimizer's trials are 48 numbers on each of 2 problems. Those of a problem depend on each other as stages of one
search do: a random walk, rounded so that values tie, or one heavy-tailed number 48 times over. Identical optimizers
have trials of one distribution; the last column is of two optimizers, the second of which has its numbers moved by one
standard deviation.
"""

import sys
from collections.abc import Callable

import numpy as np

from bench.analysis.similarity import similarity

PROBLEMS, NUMBERS = 2, 48

Draw = Callable[[np.random.Generator, int], np.ndarray]


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    rng = np.random.default_rng(27)
    print(
        "numbers      optimizers  trials  any pair of identical ones called different  one of two moved by 1 SD found"
    )
    for name, draw in (("random walk", walk), ("one number", repeated)):
        for optimizers, trials in ((2, 10), (2, 30), (5, 12), (5, 30)):
            wrong = [separated(rng, draw, [0.0] * optimizers, trials) for _ in range(repeats)]
            found = [separated(rng, draw, [0.0, 1.0], trials) for _ in range(repeats)]
            print(f"{name:12} {optimizers:10} {trials:7}  {rate(wrong):>42}  {rate(found):>31}", flush=True)


def separated(rng: np.random.Generator, draw: Draw, shifts: list[float], trials: int) -> bool:
    """Return whether any pair of optimizers with these shifts is called different."""
    behaviours = {
        str(number): [draw(rng, trials) + shift for _ in range(PROBLEMS)] for number, shift in enumerate(shifts)
    }
    return not similarity(behaviours).pairs["alike"].all()


def walk(rng: np.random.Generator, trials: int) -> np.ndarray:
    """Return (trials, numbers) of which each depends on those before it, with ties."""
    steps = rng.standard_normal((trials, NUMBERS)).cumsum(axis=1) / np.sqrt(np.arange(1, NUMBERS + 1))
    return steps.round(1)


def repeated(rng: np.random.Generator, trials: int) -> np.ndarray:
    """Return (trials, numbers) that are one number of a t distribution with 3 degrees of freedom each."""
    return np.repeat(rng.standard_t(3, (trials, 1)) / np.sqrt(3), NUMBERS, axis=1)


def rate(found: list[bool]) -> str:
    """Return a share with its standard error, that of two more cases of either kind: none seen is not none at all."""
    adjusted = (np.sum(found) + 2) / (len(found) + 4)  # Agresti and Coull 1998, The American Statistician 52
    return f"{100 * np.mean(found):.1f}% +- {100 * np.sqrt(adjusted * (1 - adjusted) / (len(found) + 4)):.1f}"


if __name__ == "__main__":
    main()
