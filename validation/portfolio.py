"""How often a page claims a gap between virtual and single best, or that choosing by features pays, without either.

    python validation/portfolio.py [REPEATS]        # default: 500 studies of each kind

A trial reaches a share of 50 targets: the mean share of its problem, and noise. Equal optimizers have the same noise;
those of unequal spread have noise of one, two, three or four times 0.03 about the same mean and median, so that A12 is
0.5 for each pair. Each function has two problems.

Columns: a gap claimed; the mean gap in points where the same trials choose and score; a gap found between complementary
optimizers, each better by 0.1 on its own share of the functions; and, of a fifth of the studies, the choice by random
features, whose sample costs nothing, claimed to pay: against the single best of all trials, as a page does, and against
one that is chosen anew without each function.
"""

import sys

import numpy as np
import pandas as pd

from bench.analysis.portfolio import SPLITS, Halves, best_gap, over_functions, student
from bench.analysis.selection import LEAST_FUNCTIONS, cell_scores, selection_gain, validated_selection

TARGETS, PROBLEMS = 50, 2
SIZES = ((3, 4, 5), (3, 4, 30), (6, 8, 10), (6, 24, 2), (6, 24, 10), (20, 24, 10))  # optimizers, functions, trials


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    heads = ("gap claimed", "same trials", "gap found", "choice claimed", "chosen anew")
    print("spread   optimizers  functions  trials" + "".join(f"{head:>16}" for head in heads))
    for optimizers, functions, trials in SIZES:
        for name, spread in (("equal", np.full(optimizers, 0.06)), ("unequal", 0.03 * (1 + np.arange(optimizers) % 4))):
            rng = np.random.default_rng((32, optimizers, functions, trials))
            equal = [halves(rng, study(rng, functions, trials, spread)) for _ in range(repeats)]
            gaps = [best_gap(each).iloc[0] for each in equal]
            found = [best_gap(halves(rng, study(rng, functions, trials, spread, 0.1)))["shown"][0] for _ in gaps]
            few = functions < LEAST_FUNCTIONS
            choices = [] if few else [choice(rng, study(rng, functions, trials, spread)) for _ in gaps[: repeats // 5]]
            same = f"{100 * np.mean([on_same_trials(each) for each in equal]):.1f} points"
            texts = [rate([gap["shown"] for gap in gaps]), same, rate(found)]
            texts += [rate(own) for own in zip(*choices, strict=True)] or ["-", "-"]
            line = f"{name:8} {optimizers:10} {functions:10} {trials:7}"
            print(line + "".join(f"{text:>16}" for text in texts), flush=True)


def study(rng: np.random.Generator, functions: int, trials: int, spread: np.ndarray, better: float = 0.0) -> np.ndarray:
    """Return the scores of a study, (problems, optimizers, trials)."""
    problems, optimizers = functions * PROBLEMS, len(spread)
    mean = 0.5 + 0.05 * rng.standard_normal(problems)
    values = mean[:, None, None] + spread[:, None] * rng.standard_normal((problems, optimizers, trials))
    values[np.arange(problems), np.repeat(np.arange(functions), PROBLEMS) % optimizers] += better
    return (np.clip(values, 0, 1) * TARGETS).round() / TARGETS


def names(problems: int) -> dict[str, str]:
    """Return the function of each problem."""
    return {f"f{number // PROBLEMS}-{number % PROBLEMS}": f"f{number // PROBLEMS}" for number in range(problems)}


def halves(rng: np.random.Generator, values: np.ndarray) -> Halves:
    """Return the scores in halves, divided as in the product, all problems at once."""
    problems, optimizers, trials = values.shape
    choose, score = np.empty((2, 2 * SPLITS, problems, optimizers))
    for split in range(0, 2 * SPLITS, 2):
        mixed = np.take_along_axis(values, rng.random((problems, 1, trials)).argsort(axis=2), axis=2)
        parts = mixed[..., : trials // 2].mean(axis=2), mixed[..., trials // 2 :].mean(axis=2)
        choose[split], score[split] = parts
        score[split + 1], choose[split + 1] = parts
    blocks, labels, equal = names(problems), [str(each) for each in range(optimizers)], np.full(problems, 1 / problems)
    return Halves(list(blocks), labels, blocks, choose.round(12), score, values.mean(axis=2).round(12), equal)


def on_same_trials(own: Halves) -> float:
    """Return the gap where the same trials choose and score."""
    return float(own.weights @ own.whole.max(axis=1) - (own.weights @ own.whole).max())


def choice(rng: np.random.Generator, values: np.ndarray) -> tuple[bool, bool]:
    """Return whether a choice by random features is claimed to pay, against both kinds of single best."""
    blocks = names(len(values))
    problems = np.array(list(blocks), dtype=object)
    place, optimizer, trial = (each.ravel() for each in np.indices(values.shape))
    scores = pd.DataFrame(
        {"problem": problems[place], "optimizer": optimizer.astype(str), "trial": trial, "score": values.ravel()}
    )
    features = pd.DataFrame(rng.standard_normal((len(problems), 4)), problems, ["a.1", "a.2", "b.1", "b.2"])
    validated = validated_selection(features, scores, scores, blocks)
    plain = over_functions(cell_scores(scores), blocks)
    others = ((plain.sum() - plain) / (len(plain) - 1)).idxmax(axis=1)
    own = validated.groupby("function", sort=False)["score"].mean()
    anew = student([own[function] - plain.loc[function, others[function]] for function in plain.index])
    return bool(selection_gain(validated)[1] > 0), bool(anew[1] > 0)


def rate(found: list[bool]) -> str:
    """Return a share with its standard error, that of two more cases of either kind: none seen is not none at all."""
    adjusted = (np.sum(found) + 2) / (len(found) + 4)  # Agresti and Coull 1998, The American Statistician 52
    return f"{100 * np.mean(found):.1f}% +- {100 * np.sqrt(adjusted * (1 - adjusted) / (len(found) + 4)):.1f}"


if __name__ == "__main__":
    main()
