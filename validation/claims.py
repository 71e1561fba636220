"""How often a page claims a difference where there is none, in designs chosen to mislead it; its power; its intervals.

    python validation/claims.py [STUDIES]        # default: 2,000 a row; about a quarter of an hour

The functions are those of the page. *Any claim* is a winner, a difference over all problems or one on a problem, at the
levels that the design gets; all optimizers are equal, or the best two of them are, in the sense of A12. *Further
problems* is the one-sided share of samples of problems with which the test claims a mean of A12 other than 0.5, for a
population of problems whose mean is 0.5, and the share of 95% intervals that hold the mean. *These problems* is the
same for problems whose A12 differ, but have the mean 0.5. In brackets: standard errors.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import numpy as np
from scipy.stats import norm

from bench import analysis
from bench.analysis import bounded
from bench.analysis.across import p_of_means
from bench.analysis.direction import Effects, effects, intervals, mean_of, p_values, stacked
from bench.analysis.error_rates import Stratum, claims
from bench.typing import Flags, Floats

Draw = Callable[[np.random.Generator, int, int, int], Floats]  # optimizers, studies, trials


def equal(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    return rng.standard_normal((optimizers, studies, trials))


def two_best(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    return equal(rng, optimizers, studies, trials) + 1.5 * (np.arange(optimizers) > 1)[:, np.newaxis, np.newaxis]


def spread(ratio: float) -> Draw:
    """Standard deviations from 1 to ``ratio``, so that A12 is 0.5 for every pair."""
    return lambda rng, k, studies, trials: (
        rng.standard_normal((k, studies, trials)) * np.geomspace(1, ratio, k)[:, np.newaxis, np.newaxis]
    )


def successes(rate: float) -> Draw:
    return lambda rng, k, studies, trials: (rng.random((k, studies, trials)) >= rate).astype(np.float64)


def mostly_tied(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    values = np.exp(equal(rng, optimizers, studies, trials))
    return values * (rng.random(values.shape) < 0.1)


def failures(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    values = equal(rng, optimizers, studies, trials)
    values[rng.random(values.shape) < 0.2] = np.inf
    return values


EQUALS = (  # name, draw, then designs of optimizers, problems and trials
    ("identical", equal, (
        (2, 1, 5), (2, 1, 15), (2, 2, 3), (2, 5, 5), (2, 7, 15), (2, 10, 30), (2, 18, 30), (2, 24, 1), (2, 24, 5),
        (2, 24, 15), (2, 29, 51), (2, 50, 5), (3, 1, 15), (3, 10, 15), (3, 24, 15), (5, 1, 15), (5, 1, 51), (5, 2, 15),
        (5, 5, 3), (5, 7, 5), (5, 18, 30), (5, 24, 1), (5, 24, 15), (5, 29, 15), (10, 1, 30), (10, 2, 15), (10, 10, 5),
        (10, 24, 15), (10, 50, 3),
    )),
    ("two tied best", two_best, (
        (3, 1, 15), (3, 1, 51), (3, 5, 15), (3, 10, 5), (3, 24, 15), (5, 1, 30), (5, 7, 15), (5, 24, 15), (5, 50, 3),
        (10, 1, 51), (10, 18, 15),
    )),
    ("spreads 1 to 3", spread(3.0), ((2, 1, 15), (2, 5, 5), (2, 24, 15), (5, 24, 5))),
    ("spreads 1 to 100", spread(100.0), (
        (2, 1, 5), (2, 1, 15), (2, 1, 51), (2, 2, 5), (2, 5, 3), (2, 24, 3), (2, 24, 15), (5, 1, 15), (5, 24, 5),
        (10, 7, 15),
    )),
    ("success .5", successes(0.5), ((2, 1, 15), (2, 24, 5), (5, 24, 15))),
    ("success .9", successes(0.9), ((2, 1, 30), (2, 1, 51), (2, 24, 15), (5, 1, 51), (5, 24, 5), (5, 24, 51))),
    ("90% ties", mostly_tied, ((2, 1, 51), (2, 24, 5), (2, 24, 15), (5, 10, 30))),
    ("20% failures", failures, ((2, 1, 15), (2, 24, 5), (5, 24, 15))),
)  # fmt: skip
POPULATIONS = (  # shares and values of A12 of a problem, of mean 0.5
    ((0.8, 0.2), (0.6, 0.1)), ((0.9, 0.1), (0.55, 0.05)), ((0.95, 0.05), (0.525, 0.025)), ((0.2, 0.8), (0.9, 0.4)),
    ((0.1, 0.9), (0.95, 0.45)), ((0.05, 0.95), (0.975, 0.475)), ((0.5, 0.5), (1.0, 0.0)), ((0.5, 0.5), (0.8, 0.2)),
    ((0.6, 0.2, 0.2), (0.5, 0.9, 0.1)), ((0.7, 0.2, 0.1), (0.6, 0.35, 0.1)),
)  # fmt: skip


def main(studies: int) -> None:
    header("any claim", "k", "N", "n", "problem", "over all", "winner", "any")
    for name, draw, designs in EQUALS:
        for k, problems, trials in designs:
            row(name, k, problems, trials, *map(share, false_claims(draw, k, problems, trials, studies)))
    for name, sizes in (("sizes 5, 30", (5, 30)), ("sizes 3, 51", (3, 51)), ("sizes 15, 30, 51", (15, 30, 51))):
        for problems in (1, 24):
            found = false_claims(equal, len(sizes), problems, min(sizes), studies, sizes=sizes)
            row(name, len(sizes), problems, min(sizes), *map(share, found))
    for variance in (0.2, 0.5, 0.8):
        for k, problems, trials in ((2, 1, 3), (2, 24, 5), (5, 24, 3)):
            shared = false_claims(equal, k, problems, trials, studies, instances=5, variance=variance)
            row(f"5 instances, {variance} between", k, problems, trials, *map(share, shared))
    header("further problems", "N", "n", "too low", "too high", "interval")
    for shares, values in POPULATIONS:
        for problems in (2, 5, 7, 10, 18, 24, 29, 50):
            for trials in (15, 51) if problems in (10, 29) else (51,):
                beyond = further(shares, values, problems, trials, studies)
                row(f"{values} on {shares}", problems, trials, *map(share, beyond))
    header("clusters of blocks, declared", "size", "blocks", "too low", "too high", "interval")
    for size in (2, 4, 8):
        row("normal shifts, SD 1", size, 24 // size, *map(share, clusters(size, 24 // size, studies)))
    header("these problems", "N", "n", "claimed", "interval")
    for shares, values in POPULATIONS:
        for problems, trials in ((5, 3), (10, 5), (10, 15), (20, 51)):
            row(
                f"{values} on {shares}", problems, trials,
                *map(share, these(values, shares, problems, trials, studies)),
            )  # fmt: skip
    header("interval, one problem, spread 10", "n", "A12 = .5", "A12 = .7", "A12 = .9")
    for trials in (3, 5, 10, 15, 30, 51):
        row("normal", trials, *(share(one_problem(true, trials, studies)) for true in (0.5, 0.7, 0.9)))
    header("power", "k", "N", "n", "found", "found further")
    for k, problems, trials, shift in ((2, 24, 15, 0.15), (2, 10, 15, 0.25), (5, 24, 15, 0.2)):
        row(f"shift {shift} SD", k, problems, trials, *map(share, power(k, problems, trials, shift, studies)))
    first, second = np.zeros((studies, 51)), successes(0.85)(np.random.default_rng(1), 1, studies, 51)[0]
    row("success 1 against 0.85", 2, 1, 51, share(p_values(effects(first, second)) <= analysis.ALPHA), "")


def header(*names: str) -> None:
    print("\n" + names[0].ljust(40) + "".join(name.rjust(15) for name in names[1:]), flush=True)


def row(name: str, *cells: object) -> None:
    print(name.ljust(40) + "".join(str(cell).rjust(15) for cell in cells), flush=True)


def share(flags: Flags) -> str:
    mean = float(flags.mean())
    return f"{mean:.3f} ({(mean * (1 - mean) / flags.size) ** 0.5:.3f})"


def false_claims(
    draw: Draw, k: int, problems: int, trials: int, studies: int,
    sizes: Sequence[int] = (), instances: int = 1, variance: float = 0.0,
) -> tuple[Flags, Flags, Flags, Flags]:  # fmt: skip
    """Return which studies claim anything false; with two tied best, any claim between these two, or a winner."""
    rng, pairs = np.random.default_rng((k, problems, trials)), k * (k - 1) // 2
    smaller = sorted(sizes)[-2] if sizes else trials * instances
    level = analysis.levels([smaller] * problems, pairs, pairs * problems)

    def strata() -> list[Stratum]:
        drawn: list[Stratum] = []
        for _ in range(instances):
            values = draw(rng, k, studies, max(sizes, default=trials)) * (1 - variance) ** 0.5
            values = values + variance**0.5 * rng.standard_normal((studies, 1))
            drawn.append([own[:, :size] for own, size in zip(values, sizes or [trials] * k, strict=True)])
        return drawn

    tied = 2 if draw is two_best else k
    on_problem, over_all, winner = claims((strata() for _ in range(problems)), level, tied)
    return on_problem, over_all, winner, on_problem | over_all | winner


def of_chances(rng: np.random.Generator, chances: Floats, trials: int) -> Effects:
    """Return estimates of A12, of the shape of ``chances``, from pairs of samples that have them for truth."""
    this, other = rng.standard_normal((2, chances.size, trials))
    found = effects(this, other + np.sqrt(2) * norm.ppf(chances.clip(1e-12, 1 - 1e-12)).reshape(-1, 1))
    return Effects(*(np.broadcast_to(each, chances.size).reshape(chances.shape) for each in found))


def further(shares: Sequence[float], values: Sequence[float], problems: int, trials: int, studies: int) -> list[Flags]:
    rng = np.random.default_rng(problems)
    chances = rng.choice(np.array(values), p=shares, size=(problems, studies))
    return _further(of_chances(rng, chances, trials).a12)


def clusters(size: int, blocks: int, studies: int, trials: int = 15) -> list[Flags]:
    rng = np.random.default_rng(size)
    shifts = np.repeat(rng.standard_normal((blocks, studies)), size, axis=0)
    found = of_chances(rng, norm.cdf(shifts), trials).a12
    return _further(found.reshape(blocks, size, studies).mean(axis=1))


def _further(means: Floats) -> list[Flags]:
    clear, above = bounded.p_values(means) <= 0.05, means.mean(axis=0) > 0.5
    low, high = bounded.intervals(means)
    return [clear & above, clear & ~above, (low <= 0.5) & (high >= 0.5)]


def these(values: Sequence[float], shares: Sequence[float], problems: int, trials: int, studies: int) -> list[Flags]:
    number = np.diff(np.append(0, np.round(np.cumsum(shares) * problems).astype(int)))
    chances = np.repeat(np.array(values), number)
    truth = float(chances.mean())
    found = of_chances(np.random.default_rng(1), np.tile(chances[:, np.newaxis], (1, studies)), trials)
    low, high = intervals(mean_of(found))
    claimed = p_of_means(found) <= 0.05
    wrong = claimed & ((found.a12.mean(axis=0) > 0.5) != (truth > 0.5)) if abs(truth - 0.5) > 1e-9 else claimed
    return [wrong, (low <= truth) & (truth <= high)]


def one_problem(true: float, trials: int, studies: int, ratio: float = 10.0) -> Flags:
    this, other = np.random.default_rng(trials).standard_normal((2, studies, trials))
    shift = np.sqrt(1 + ratio**2) * norm.ppf(true)
    low, high = intervals(mean_of(stacked([effects(this, ratio * other + shift)])))
    return np.asarray((low <= true) & (true <= high))


def power(k: int, problems: int, trials: int, shift: float, studies: int) -> list[Flags]:
    """Return which studies name the first of k optimizers the winner, and whether on further problems too."""
    rng, pairs = np.random.default_rng(1), k * (k - 1) // 2
    level = analysis.levels([trials] * problems, pairs, pairs * problems).across
    values = rng.standard_normal((problems, k, studies, trials))
    values[:, 1:] += shift
    every = [stacked([effects(of[0], of[rival]) for of in values]) for rival in range(1, k)]
    shown = [(p_of_means(found) <= level) & (found.a12.mean(axis=0) > 0.5) for found in every]
    beyond = [bounded.p_values(found.a12) <= level for found in every]
    won = np.all(shown, axis=0)
    return [won, won & np.all(beyond, axis=0)]


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000)
