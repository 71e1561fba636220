"""How often a page marks a difference beside its verdict where there is none, by simulation.

    python validation/other_claims.py [STUDIES] [stars] [leads]     # default: 300 studies a row, 15 minutes

- A star of the table of running times: identical optimizers; the time to each target is lognormal and increases with
  the target, and a trial ends by chance on the way. "grid": times are multiples of a population of 300.
- A lead at a smaller budget: identical optimizers, whose best values decrease in steps that are independent of each
  other ("steps") or all come from one basin of two ("basins"); the leader is the one that most often ends lower.
"""

import sys
from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

from bench.analysis.direction import wins
from bench.analysis.running_time import separably_fastest
from bench.analysis.stages import SHARES, earlier_leads
from bench.objective import Trace

BUDGET = 10_000


def main() -> None:
    studies = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    parts = {"stars": ("a star", stars), "leads": ("a lead", leads)}
    for title, rows in (parts[name] for name in sys.argv[2:] or parts):
        print(f"\n{title:62} share of {studies} studies (standard error)", flush=True)
        for label, claims in rows():
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


def leads() -> Iterator[tuple[str, Callable[[np.random.Generator], bool]]]:
    for k, problems, n in [(2, 1, 30), (2, 24, 15), (5, 24, 15), (5, 18, 30), (5, 6, 5), (10, 3, 10)]:
        for kind in ("steps", "basins"):
            label = f"{k} optimizers, {problems} problems, {n} trials, {kind}"
            yield label, lambda rng, design=(k, problems, n, kind): lead(rng, *design)


def lead(rng: np.random.Generator, k: int, problems: int, n: int, kind: str) -> bool:
    """Return whether a page of identical optimizers states that another one than the leader led before."""
    steps = rng.exponential(1.0, (problems, k, n, len(SHARES)))
    if kind == "basins":
        steps = np.round(steps * (rng.random((problems, k, n, 1)) < 0.5), 1)
    values = 20 - np.cumsum(steps, axis=-1)
    ends = [
        [wins(values[p, one, :, -1], values[p, :, :, -1].ravel()).mean() for one in range(k)] for p in range(problems)
    ]
    at = np.maximum(np.round(np.array(SHARES) * BUDGET), 1).astype(np.int64)
    keys = [(f"p{p}", f"o{one}", trial) for p in range(problems) for one in range(k) for trial in range(n)]
    traces = {key: Trace(at, curve) for key, curve in zip(keys, values.reshape(-1, len(SHARES)), strict=True)}
    frame = pd.DataFrame(keys, columns=["problem", "optimizer", "trial"]).assign(
        status="ok", fun=values[..., -1].ravel()
    )
    leader = f"o{int(np.mean(ends, axis=0).argmax())}"
    found = earlier_leads(frame, traces, {f"p{p}": BUDGET for p in range(problems)}, leader)
    return bool(found["shown"].any())


if __name__ == "__main__":
    main()
