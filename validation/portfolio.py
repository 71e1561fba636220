"""How often a page claims a gap between virtual and single best, or that choosing by features pays, without either.

    python validation/portfolio.py [REPEATS]        # default: 200 studies of each kind

A trial reaches a share of 50 targets: the mean share of its problem, and noise. Equal optimizers have the same noise;
those of unequal spread have noise of one, two, three or four times 0.03 about the same mean and median, so that A12 is
0.5 for each pair. Each function has two problems. Features are random numbers, and the sample costs nothing.

Columns: a gap claimed; the gap in points where the same trials choose and score; the choice by features claimed to pay;
the same against a single best that is chosen anew without each function; and of complementary optimizers, each better
by 0.1 on its own share of the functions, which one feature shows: the gap found, the choice found.
"""

import sys

import numpy as np
import pandas as pd

from bench.analysis.portfolio import Halves, best_gap, over_functions, student
from bench.analysis.selection import LEAST_FUNCTIONS, cell_scores, selection_gain, validated_selection

TARGETS, PROBLEMS = 50, 2
SIZES = ((3, 4, 5), (3, 4, 30), (6, 8, 10), (6, 24, 2), (6, 24, 10), (20, 24, 10))  # optimizers, functions, trials


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    heads = ("gap claimed", "same trials", "choice claimed", "chosen anew", "gap found", "choice found")
    print("spread   optimizers  functions  trials" + "".join(f"{head:>16}" for head in heads))
    for optimizers, functions, trials in SIZES:
        for spread in (np.full(optimizers, 0.06), 0.03 * (1 + np.arange(optimizers) % 4)):
            rng = np.random.default_rng((32, optimizers, functions, trials))
            found = [
                (*claims(*study(rng, functions, trials, spread)), *claims(*study(rng, functions, trials, spread, 0.1)))
                for _ in range(repeats)
            ]
            gap, same, choice, anew, gap_found, _, choice_found, _ = zip(*found, strict=True)
            texts = [rate(gap), f"{100 * np.mean(same):.1f} points", rate(choice), rate(anew), rate(gap_found)]
            name = "unequal" if np.ptp(spread) else "equal"
            line = f"{name:8} {optimizers:10} {functions:10} {trials:7}"
            print(line + "".join(f"{text:>16}" for text in (*texts, rate(choice_found))), flush=True)


def claims(scores: pd.DataFrame, blocks: dict[str, str], features: pd.DataFrame) -> tuple[bool, float, bool, bool]:
    """Return whether a gap is claimed, the gap on the same trials, and whether a choice is claimed to pay, twice."""
    gap = best_gap(Halves.of(scores, blocks)).iloc[0]
    validated = validated_selection(features, scores, scores, blocks)
    if len(set(blocks.values())) < LEAST_FUNCTIONS:
        return bool(gap["shown"]), gap["same_trials"], False, False
    plain = over_functions(cell_scores(scores), blocks)
    others = ((plain.sum() - plain) / (len(plain) - 1)).idxmax(axis=1)
    own = validated.groupby("function", sort=False)["score"].mean()
    gains = [own[function] - plain.loc[function, others[function]] for function in plain.index]
    return bool(gap["shown"]), gap["same_trials"], selection_gain(validated)[1] > 0, student(gains)[1] > 0


def study(
    rng: np.random.Generator, functions: int, trials: int, spread: np.ndarray, better: float = 0.0
) -> tuple[pd.DataFrame, dict[str, str], pd.DataFrame]:
    """Return the scores of a study, the function of each problem, and features."""
    problems, optimizers = functions * PROBLEMS, len(spread)
    mean = 0.5 + 0.05 * rng.standard_normal(problems)
    values = mean[:, None, None] + spread[:, None] * rng.standard_normal((problems, optimizers, trials))
    favoured = np.repeat(np.arange(functions), PROBLEMS) % optimizers
    values[np.arange(problems), favoured] += better
    place, optimizer, trial = (each.ravel() for each in np.indices(values.shape))
    names = np.array([f"f{number // PROBLEMS}-{number % PROBLEMS}" for number in range(problems)], dtype=object)
    scores = pd.DataFrame({"problem": names[place], "optimizer": optimizer.astype(str), "trial": trial})
    scores["score"] = (np.clip(values, 0, 1) * TARGETS).round().ravel() / TARGETS
    features = pd.DataFrame(rng.standard_normal((problems, 4)), index=names, columns=["a.1", "a.2", "a.3", "b.1"])
    if better:
        features = pd.DataFrame({"a.1": 1.0 * favoured}, index=names)
    return scores, {name: name.split("-")[0] for name in names}, features


def rate(found: tuple[bool, ...]) -> str:
    """Return a share with its standard error, that of two more cases of either kind: none seen is not none at all."""
    adjusted = (np.sum(found) + 2) / (len(found) + 4)  # Agresti and Coull 1998, The American Statistician 52
    return f"{100 * np.mean(found):.1f}% +- {100 * np.sqrt(adjusted * (1 - adjusted) / (len(found) + 4)):.1f}"


if __name__ == "__main__":
    main()
