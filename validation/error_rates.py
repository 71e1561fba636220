"""How often the claims of a page are wrong, and how often its intervals hold, by simulation, with standard errors.

    python validation/error_rates.py [STUDIES]        # default: 2,000 a row; some minutes

*Claims*: the share of studies that claim any difference where there is none, at the levels that their design gets; and
the smallest A12 that each kind of test finds with a power of 80%. In *equal* studies the optimizers are identical, on
problems of all kinds below; in *spread* studies A12 is 0.5 for every pair and the spread doubles from one optimizer to
the next. *Intervals*: the share of 95% intervals that hold the true value. That of a mean rank is the expected mean
rank of studies with as many trials; that of further problems is the mean of A12 over the population of problems.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.stats import norm

from bench import analysis
from bench.analysis.certainty import ranks_of_draws
from bench.analysis.direction import effects, intervals
from bench.typing import Floats

DESIGNS = (  # problems, independent blocks of them, trials a cell, optimizers
    (1, 1, 30, 5), (1, 1, 30, 10), (3, 3, 30, 2), (3, 3, 30, 5), (18, 18, 30, 2), (18, 18, 30, 5), (18, 18, 30, 10),
    (18, 1, 30, 5), (18, 18, 5, 5), (72, 24, 5, 2), (72, 24, 5, 5), (72, 24, 15, 5),
    (72, 24, 16, 5),
)  # fmt: skip
POPULATIONS = ((18, 18, 0.0), (18, 18, 0.5), (18, 18, 2.0), (72, 24, 0.5))  # problems, blocks, SD of their shifts
KINDS = ("normal", "three times the spread", "two basins", "ties at the optimum")
TRIALS = (5, 10, 30)


def main(studies: int) -> None:
    fewer = max(studies // 20, 2)
    print(f"{studies:,} studies a row, {fewer:,} of mean ranks; in brackets: standard errors")
    header("any claim without a difference", "equal", "spread", "found on one", "found over all")
    for problems, blocks, trials, optimizers in DESIGNS:
        name = f"{problems} x {trials}, blocks: {blocks}, optimizers: {optimizers}"
        print(name.ljust(44) + claims(problems, blocks, trials, optimizers, studies), flush=True)
    header("interval of A12", *(f"{n} trials" for n in TRIALS))
    for kind in KINDS:
        for true in (0.5, 0.75, 0.95):
            row(f"{kind}, true {true}", [a12_holds(kind, true, n, studies) for n in TRIALS])
    header("interval of the mean rank", *(f"{n} trials" for n in TRIALS))
    for step in (0.1, 0.5):
        row(f"18 problems, optimizers {step} SD apart", [rank_holds(step, n, fewer) for n in TRIALS])
    header("probability of improvement, 10 trials", "these problems", "further ones")
    for problems, blocks, spread in POPULATIONS:
        row(f"{problems} problems, blocks: {blocks}, SD {spread}", improvement_holds(problems, blocks, spread, studies))


def header(*names: str) -> None:
    print("\n" + names[0].ljust(44) + "".join(name.rjust(15) for name in names[1:]))


def row(name: str, held: Sequence[Floats]) -> None:
    """Print shares with their standard errors; the first axis of each of ``held`` are independent studies."""
    means = [own.reshape(len(own), -1).mean(axis=1) for own in held]
    cells = [f"{own.mean():.3f} ({own.std() / len(own) ** 0.5:.3f})" for own in means]
    print(name.ljust(44) + "".join(cell.rjust(15) for cell in cells), flush=True)


def claims(problems: int, blocks: int, trials: int, optimizers: int, studies: int) -> str:
    pairs = optimizers * (optimizers - 1) // 2
    level = analysis.levels([trials] * problems, pairs, pairs * problems, blocks)
    names = [str(place % blocks) for place in range(problems)]
    rates, made = np.zeros(2), 0
    while made < studies:
        rng = np.random.default_rng(made)
        half = -(-trials * optimizers // 2)
        values = [draw(rng, KINDS[place % len(KINDS)], 0.5, (half,)) for place in range(problems)]
        pools = [np.concatenate(pair)[: trials * optimizers] for pair in values]
        equal = analysis.rates_of_equals(pools, optimizers, names, level, seed=made)
        spread = analysis.rates_of_spreads(trials, optimizers, names, level, seed=made)
        rates += equal.studies * np.array([equal.any, spread.any])
        made += equal.studies
    shown = [f"{each:.3f} ({(each * (1 - each) / made) ** 0.5:.3f})" for each in rates / made]
    found = [np.nan, np.nan]
    if level.problems:
        found[0] = analysis.detectable_a12(trials, level.problems / (pairs * problems))
    if level.across:
        number = blocks if level.further else problems
        found[1] = analysis.detectable_across(trials, number, level.across / pairs, level.further)
    shown += ["-" if np.isnan(each) else f"A12 = {each:.2f}" for each in found]
    return "".join(cell.rjust(15) for cell in shown)


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


def rank_holds(step: float, trials: int, studies: int, problems: int = 18, optimizers: int = 5) -> Floats:
    """Return whether the intervals of (studies, optimizers) mean ranks hold the expected mean rank."""
    rng, shifts = np.random.default_rng(1), step * np.arange(optimizers)[:, np.newaxis]
    expected, once = np.zeros(optimizers), [np.ones((trials, 1))] * optimizers
    repeats = 10_000
    for _ in range(repeats):
        expected += ranks_of_draws(rng.standard_normal((optimizers, trials)) + shifts, once)[:, 0] / repeats
    index = pd.MultiIndex.from_product([range(problems), range(optimizers), range(trials)])
    frame = index.to_frame(index=False, name=["problem", "optimizer", "trial"]).assign(status="ok")
    frame = frame.astype({"problem": "category", "optimizer": "category"})
    held = np.empty((studies, optimizers), dtype=bool)
    for study in range(studies):
        values = rng.standard_normal((problems, optimizers, trials)) + shifts
        found = analysis.ranking_certainty(frame.assign(fun=values.ravel()), seed=study)
        held[study] = (found["rank_low"] <= expected) & (expected <= found["rank_high"])
    return held


def improvement_holds(problems: int, blocks: int, spread: float, studies: int, trials: int = 10) -> list[Floats]:
    """Return whether the intervals for these problems and for further ones hold; a study is a pair of optimizers."""
    rng, block = np.random.default_rng(1), np.arange(problems) % blocks
    scale = np.sqrt([0.9, 0.1]) * spread  # steps of one block are much alike
    shifts = 0.5 + scale[0] * rng.standard_normal((blocks, studies))[block]
    shifts += scale[1] * rng.standard_normal((problems, studies))
    this, other = rng.standard_normal((2, problems, studies, trials))
    found = effects(this.reshape(-1, trials), (other + shifts[..., np.newaxis]).reshape(-1, trials))
    index = pd.MultiIndex.from_product([map(str, range(problems)), map(str, range(studies)), ["other"]])
    pairs = index.to_frame(index=False, name=["problem", "first", "second"])
    pairs = pairs.assign(n_first=trials, n_second=trials, a12=found.a12, ratio=found.ratio)
    table = analysis.probability_of_improvement(pairs, {str(place): f"block {own}" for place, own in enumerate(block)})
    these = norm.cdf(shifts / np.sqrt(2)).mean(axis=0)
    further = norm.cdf(0.5 / np.sqrt(2 + spread**2))
    return [
        ((table[f"{which}low"] <= true) & (true <= table[f"{which}high"])).to_numpy()
        for which, true in (("", these), ("further_", further))
    ]


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000)
