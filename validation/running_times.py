"""Coverage of the 95% intervals of the expected running time (ERT), by simulation.

    python validation/running_times.py [CELLS]        # default: 10,000 cells of each kind, a minute of CPU time

The time of a success is exponential, lognormal or uniform, cut at the budget. A trial fails either because its time is
longer than the budget, or by chance, with a budget of five or fifty times the mean time (a second basin, say).
A failure costs the budget, or, "early", ends anywhere before it. Successful trials end at the target or spend the
budget ("spent"), which must make no difference; the budget is known, or is the longest trial seen ("unknown").
Shares are of the intervals that are given: cells without a success have none.
"""

import sys
from collections.abc import Iterator

import numpy as np
import pandas as pd

from bench.analysis.running_time import running_times

TIMES = {
    "exponential": lambda rng, shape: rng.exponential(1.0, shape),
    "lognormal": lambda rng, shape: rng.lognormal(0.0, 1.0, shape),
    "uniform": lambda rng, shape: rng.uniform(0.0, 1.0, shape),
}
FAILURES = ("longer than the budget", 5, 50)  # numbers: the budget in mean times
SUCCESS = (0.5, 0.7, 0.9, 1.0)
TRIALS = (5, 10, 30)
AT_ONCE = 200_000  # trials in a frame
MANY = 1_000_000  # draws that the true mean time comes from


def main() -> None:
    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    rng = np.random.default_rng(27)
    columns = [(success, n) for success in SUCCESS for n in TRIALS]
    print("success".rjust(46), *(f"{success:5.1f}" for success, _ in columns))
    print("trials".rjust(46), *(f"{n:5}" for _, n in columns))
    every = []
    for name, fails, spent in kinds():
        row = []
        for success, n in columns:
            covered, given = coverage(rng, name, fails, success, n, spent, cells)
            row.append(covered / given)
            every.append((covered / given, given))
        fate = fails if isinstance(fails, str) else f"by chance, budget {fails}"
        print(f"{name:12} {fate:24} {spent:8}", *(f"{share:5.3f}" for share in row), flush=True)
    lowest, given = min(every)
    error = max(np.sqrt(share * (1 - share) / given) for share, given in every)
    own = np.sqrt(lowest * (1 - lowest) / given)
    print(f"lowest {lowest:.3f} ± {own:.3f}; standard errors are at most {error:.3f}")


def kinds() -> Iterator[tuple[str, str | int, str]]:
    """Yield the name of the times, how trials fail, and what they spend."""
    for name in TIMES:
        for fails in FAILURES:
            for spent in ("budget", "target", "early"):
                yield name, fails, spent
    yield "exponential", "longer than the budget", "unknown"


def coverage(
    rng: np.random.Generator, name: str, fails: str | int, success: float, n: int, spent: str, cells: int
) -> tuple[int, int]:
    """Return how many intervals hold the true ERT, and how many there are."""
    draws = TIMES[name](rng, MANY)
    if isinstance(fails, str):
        budget = np.quantile(draws, success) if success < 1 else 1.5 * draws.max()
        true = draws[draws <= budget].mean()
    else:
        budget = fails * draws.mean()
        true = np.minimum(draws, budget).mean()
    true += (1 - success) / success * budget * (0.5 if spent == "early" else 1.0)
    covered = given = 0
    for start in range(0, cells, AT_ONCE // n):
        shape = min(AT_ONCE // n, cells - start), n
        times = TIMES[name](rng, shape)
        reached = times <= budget if isinstance(fails, str) else rng.random(shape) < success
        times = np.minimum(times, budget)
        lost = budget * (rng.random(shape) if spent == "early" else np.ones(shape))
        table = running_times(hits(times, reached, lost, spent, budget), restarts=1)
        covered += int(((table["low"] <= true) & (true <= table["high"])).sum())
        given += int(table["low"].notna().sum())
    return covered, given


def hits(times: np.ndarray, reached: np.ndarray, lost: np.ndarray, spent: str, budget: float) -> pd.DataFrame:
    """Return the hitting times of one target of (cells, n) trials, each cell a problem of its own."""
    cells, n = times.shape
    table = pd.DataFrame(
        {
            "problem": np.repeat(np.arange(cells), n), "optimizer": "a", "trial": np.tile(np.arange(n), cells),
            "tau": 1.0, "target": 1.0, "evaluations": np.where(reached, times, np.inf).ravel(),
            "spent": np.where(reached, budget if spent == "budget" else times, lost).ravel(),
        }
    )  # fmt: skip
    return table if spent == "unknown" else table.assign(budget=budget)


if __name__ == "__main__":
    main()
