"""How often bands of runtime distributions hold the true curve, and how often they show a lead that is none.

    python validation/bands.py [STUDIES]        # default: 200 a row; about half an hour

*Covered* is the share of studies whose band holds the true curve at every budget, by problems and runs a problem, of
all targets and of the hardest one alone, whose curve is a data profile. Misses by less than 0.001 do not count, as the
truth is a mean of 20,000 runs. *Wrong leads* is the share of studies of 2 and of 5 optimizers that are equal at every
budget, or of which one is faster throughout, in which a band shows a lead that is none. In brackets: standard errors of
the worst.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pandas as pd

from bench.analysis.bands import curve_bands, leads
from bench.contract.typing import Floats

TARGETS = 8
GRID = np.geomspace(1, 1000, 40)
PROBLEMS, RUNS = (1, 6, 24), (5, 15, 51)
STEPS = np.arange(TARGETS)

Draw = Callable[[np.random.Generator, int, int], Floats]  # problem, of how many, runs -> (runs, TARGETS) times


def smooth(rng: np.random.Generator, problem: float, runs: int) -> Floats:
    """Log-normal times, whose runs are fast or slow as a whole; problems differ a thousandfold."""
    whole = rng.standard_normal((runs, 1))
    return np.exp(7 * problem + 0.5 * STEPS + 0.8 * whole + 0.3 * rng.standard_normal((runs, TARGETS)))


def memoryless(rng: np.random.Generator, problem: float, runs: int) -> Floats:
    """Exponential times from target to target."""
    return rng.exponential(10 + 60 * problem, (runs, TARGETS)).cumsum(axis=1)


def easy(rng: np.random.Generator, _: float, runs: int) -> Floats:
    """Everything is reached at the very beginning."""
    return rng.exponential(1, (runs, TARGETS)).cumsum(axis=1)


def rare(rng: np.random.Generator, _: float, runs: int) -> Floats:
    """Hard targets that few runs reach: one in two, in ten and in thirty-three."""
    chance = np.concatenate([np.ones(TARGETS - 3), [0.5, 0.1, 0.03]])
    times = 10 * np.exp(0.4 * STEPS + 0.3 * rng.standard_normal((runs, 1)))
    return np.where(rng.random((runs, 1)) < chance, times, np.inf)


def basins(rng: np.random.Generator, _: float, runs: int) -> Floats:
    """Four runs of five reach everything at the same times, the fifth gets stuck at the second target."""
    return np.where((rng.random((runs, 1)) < 0.8) | (STEPS < 2), 5 * np.exp(0.5 * STEPS), np.inf)


def stuck(rng: np.random.Generator, _: float, runs: int) -> Floats:
    """One run in thirty gets stuck at the second target, all others are alike."""
    return np.where((rng.random((runs, 1)) < 29 / 30) | (STEPS < 2), 5 * np.exp(0.5 * STEPS), np.inf)


def hopeless(rng: np.random.Generator, _: float, runs: int) -> Floats:
    """One run in fifty reaches anything at all."""
    return np.where(rng.random((runs, 1)) < 0.02, 20.0, np.inf) * np.ones(TARGETS)


def unlike(rng: np.random.Generator, problem: float, runs: int) -> Floats:
    """Problems that are solved hardly ever to nearly always."""
    times = 10 * np.exp(0.4 * STEPS + rng.standard_normal((runs, 1)))
    return np.where(rng.random((runs, 1)) < 0.02 + 0.96 * problem, times, np.inf)


def alone(rng: np.random.Generator, _: float, runs: int) -> Floats:
    """The same curve as that of :func:`together`, whose targets are reached independently of each other."""
    return np.where(rng.random((runs, TARGETS)) < 0.6, rng.uniform(10, 500, (runs, TARGETS)), np.inf)


def together(rng: np.random.Generator, _: float, runs: int) -> Floats:
    """All targets of a run at one time, or none."""
    return np.where(rng.random((runs, 1)) < 0.6, rng.uniform(10, 500, (runs, 1)), np.inf) * np.ones(TARGETS)


DESIGNS = (smooth, memoryless, easy, rare, basins, stuck, hopeless, unlike, alone, together)


def hits_of(draws: dict[str, tuple[Draw, float]], rng: np.random.Generator, problems: int, runs: int) -> pd.DataFrame:
    """Return the hitting times of a study; each optimizer's times are multiplied by a factor."""
    times = [
        factor * np.sort(draw(rng, problem / max(problems - 1, 1), runs), axis=1)
        for draw, factor in draws.values()
        for problem in range(problems)
    ]
    size = runs * TARGETS
    return pd.DataFrame(
        {
            "problem": np.tile(np.repeat(np.arange(problems), size), len(draws)),
            "optimizer": np.repeat(np.array(list(draws), dtype=object), problems * size),
            "trial": np.tile(np.repeat(np.arange(runs), TARGETS), len(draws) * problems),
            "evaluations": np.concatenate(times).ravel(),
        }
    )


def truth(draw: Draw, problems: int, targets: int = TARGETS) -> Floats:
    """Return the true curve of the hardest targets, from 20,000 runs a problem."""
    rng = np.random.default_rng(11)
    samples = [draw(rng, problem / max(problems - 1, 1), 20_000) for problem in range(problems)]
    samples = [np.sort(times, axis=1)[:, -targets:] for times in samples]
    return np.mean([[(times <= spent).mean() for spent in GRID] for times in samples], axis=0)


def covered(draw: Draw, problems: int, runs: int, studies: int, targets: int = TARGETS) -> tuple[float, float]:
    """Return the share of studies whose band holds the true curve, and the mean of its largest width.

    Of a single target, the hardest, the curve is a data profile.
    """
    rng, true, held, width = np.random.default_rng(runs), truth(draw, problems, targets), 0, 0.0
    for _ in range(studies):
        hits = hits_of({"a": (draw, 1.0)}, rng, problems, runs)
        band = curve_bands(hits[np.arange(len(hits)) % TARGETS >= TARGETS - targets], GRID)
        held += bool(((band["low"] <= true + 1e-3) & (true - 1e-3 <= band["high"])).all())
        width += float((band["high"] - band["low"]).max()) / studies
    return held / studies, width


def wrong(draws: dict[str, tuple[Draw, float]], problems: int, runs: int, studies: int) -> float:
    """Return the share of studies with a lead that is none: any of equals, or one of the slower over the faster."""
    rng, found = np.random.default_rng(runs), 0
    factor = {optimizer: factor for optimizer, (_, factor) in draws.items()}
    for _ in range(studies):
        table = leads(hits_of(draws, rng, problems, runs), GRID)
        shown = table[table["ahead"] != ""]
        other = shown["first"].where(shown["first"] != shown["ahead"], shown["second"])
        found += bool((shown["ahead"].map(factor) >= other.map(factor)).any())
    return found / studies


def main(studies: int) -> None:
    """Print all tables."""
    for what, targets in (("covered", TARGETS), ("data profile covered", 1)):
        print(f"| {what}, problems x runs |", " | ".join(f"{p} x {n}" for p in PROBLEMS for n in RUNS), "|")
        for draw in DESIGNS:
            cells = [covered(draw, problems, runs, studies, targets) for problems in PROBLEMS for runs in RUNS]
            worst = min(share for share, _ in cells)
            error = (worst * (1 - worst) / studies) ** 0.5
            texts = " | ".join(f"{share:.3f}, {width:.2f}" for share, width in cells)
            print(f"| {draw.__name__} ({error:.3f}) | {texts} |", flush=True)
    print("| wrong leads |", " | ".join(f"{p} x {n}" for p in PROBLEMS for n in RUNS), "|")
    groups = {draw.__name__: {"a": (draw, 1.0), "b": (draw, 1.0)} for draw in DESIGNS}
    groups["five, smooth"] = dict.fromkeys("abcde", (smooth, 1.0))
    groups["five, rare"] = dict.fromkeys("abcde", (rare, 1.0))
    groups["alone, together"] = {"a": (alone, 1.0), "b": (together, 1.0)}
    groups["smooth, 1.5 times slower"] = {"a": (smooth, 1.0), "b": (smooth, 1.5)}
    for name, draws in groups.items():
        shares = [wrong(draws, problems, runs, studies) for problems in PROBLEMS for runs in RUNS]
        error = (max(shares) * (1 - max(shares)) / studies) ** 0.5
        print(f"| {name} ({error:.3f}) | {' | '.join(f'{share:.3f}' for share in shares)} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
