"""How often a page claims a gap between virtual and single best, or that a choice by features pays, where neither is so.

    python validation/portfolio.py [REPEATS]        # default: 1,000 studies of each kind

A trial reaches a share of 50 targets, the mean share of the problem and noise. Equal optimizers have the same noise;
those of unequal spread have noise of one, two, three … times 0.03 about the same mean and median, so that each has
A12 = 0.5 against each other. Each function has two problems, which share half of the variance of a problem's mean. The
next column is the gap where the same trials choose and score; features are random numbers, and the sample costs
nothing. In the last column every optimizer is better by 0.2 on its own share of the functions.
"""

import sys

import numpy as np
import pandas as pd

from bench.analysis.portfolio import Halves, best_gap
from bench.analysis.selection import selection_gain, validated_selection

TARGETS = 50
DIMENSIONS = 2


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000
    rng = np.random.default_rng(32)
    print("spread   optimizers  functions  trials  gap claimed  gap on the same trials  choice claimed  complementary found")
    for optimizers, functions, trials in ((3, 4, 5), (3, 4, 30), (6, 8, 10), (6, 24, 2), (6, 24, 10), (20, 24, 10)):
        for spread in ("equal", "unequal"):
            claims, chances, choices, found = [], [], [], []
            for _ in range(repeats):
                scores, blocks, features = study(rng, optimizers, functions, trials, spread == "unequal", 0.0)
                gap = best_gap(Halves.of(scores, blocks)).iloc[0]
                claims.append(gap["shown"])
                chances.append(100 * gap["same_trials"])
                choices.append(selection_gain(validated_selection(features, scores, scores, blocks))[1] > 0)
                scores, blocks, _ = study(rng, optimizers, functions, trials, spread == "unequal", 0.2)
                found.append(best_gap(Halves.of(scores, blocks))["shown"].iloc[0])
            print(
                f"{spread:8} {optimizers:10} {functions:10} {trials:7}  {rate(claims):>11}  {np.mean(chances):>16.1f} points"
                f"  {rate(choices) if functions >= 6 else '-':>14}  {rate(found):>19}",
                flush=True,
            )


def study(
    rng: np.random.Generator, optimizers: int, functions: int, trials: int, unequal: bool, better: float
) -> tuple[pd.DataFrame, dict[str, str], pd.DataFrame]:
    """Return the scores of a study, the function of each problem, and random features."""
    problems = functions * DIMENSIONS
    shared, own = rng.normal(0, 0.05, (2, problems))
    mean = 0.5 + np.repeat(shared[:functions], DIMENSIONS) + own
    spread = 0.03 * (1 + np.arange(optimizers) % 4) if unequal else np.full(optimizers, 0.06)
    values = mean[:, None, None] + spread[:, None] * rng.standard_normal((problems, optimizers, trials))
    place = np.repeat(np.arange(functions), DIMENSIONS) % optimizers
    values[np.arange(problems), place] += better
    place, optimizer, trial = (each.ravel() for each in np.indices(values.shape))
    names = np.array([f"f{number // DIMENSIONS}-{number % DIMENSIONS}" for number in range(problems)], dtype=object)
    scores = pd.DataFrame({"problem": names[place], "optimizer": optimizer.astype(str), "trial": trial})
    scores["score"] = (np.clip(values, 0, 1) * TARGETS).round().ravel() / TARGETS
    features = pd.DataFrame(rng.standard_normal((problems, 4)), index=names, columns=list("abcd"))
    return scores, {name: name.split("-")[0] for name in names}, features.assign(dimension=2.0)


def rate(found: list[bool]) -> str:
    """Return a share with its standard error, that of two more cases of either kind: none seen is not none at all."""
    adjusted = (np.sum(found) + 2) / (len(found) + 4)  # Agresti and Coull 1998, The American Statistician 52
    return f"{100 * np.mean(found):.1f}% +- {100 * np.sqrt(adjusted * (1 - adjusted) / (len(found) + 4)):.1f}"


if __name__ == "__main__":
    main()
