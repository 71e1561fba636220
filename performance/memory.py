"""Measure the memory of a search: how much each thesis optimizer needs above the process that runs it.

    python performance/memory.py [AGENTS [RUNS]]          # default: 300, 5

A fresh process for each search: it loads all that the optimizer needs and makes a search with the fewest agents, so
that everything is imported and compiled; then the memory in use is the baseline, and the peak of the search itself is
measured above it. Medians of RUNS seeds. Two counts:

- *resident*: what the operating system sees (the peak VmHWM less VmRSS before; Linux only), in pages of 4 kB, with what
  libraries keep for later;
- *arrays and objects*: the peak of what Python and numpy allocate (tracemalloc), without compiled code's own arrays.

random-search shows what the harness itself takes: its trace, and one generation of points.
"""

import ctypes
import gc
import multiprocessing
import sys
import tracemalloc
from contextlib import suppress
from pathlib import Path
from statistics import median
from typing import NamedTuple

import bench

PROBLEM, BUDGET = "signature-12", 60_000
OPTIMIZERS = {
    "cma-es": {"handling": "box", "start": "midpoint"},
    "alo": {}, "goa": {}, "gwo": {}, "da": {}, "random-search": {},
}  # fmt: skip
FEWEST = 5  # agents that every optimizer accepts
STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


class Memory(NamedTuple):
    """Memory of one search in kB: the process before it, and its peaks above that."""

    before: float
    resident: float
    traced: float


def resident(field: str) -> float:
    """Return VmRSS (now) or VmHWM (peak) of this process in kB; NaN where the system has no such file."""
    lines = STATUS.read_text(encoding="ascii").splitlines() if STATUS.exists() else []
    return next((float(line.split()[1]) for line in lines if line.startswith(f"{field}:")), float("nan"))


def measure(name: str, agents: int, seed: int, trace: bool) -> Memory:
    """Return the memory of a search in this process, which must be fresh; ``trace`` counts allocations instead."""
    options = OPTIMIZERS[name]
    problem = bench.load_problem(PROBLEM)
    bench.solve(problem, bench.load_optimizer(name, agents=FEWEST, **options), budget=20 * FEWEST, seed=seed)
    optimizer = bench.load_optimizer(name, agents=agents, **options)
    gc.collect()
    with suppress(OSError, AttributeError):  # glibc only: a search would reuse, unseen, what loading has freed
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    before = resident("VmRSS")
    if trace:
        tracemalloc.start()
    elif RESET.exists():
        RESET.write_text("5", encoding="ascii")  # sets the peak back to what is resident now
    bench.solve(problem, optimizer, budget=BUDGET, seed=seed)
    traced = tracemalloc.get_traced_memory()[1] / 1e3 if trace else float("nan")
    return Memory(before, resident("VmHWM") - before, traced)


def medians(name: str, agents: int, runs: int) -> Memory:
    """Return the medians over seeds, each search in a process of its own."""
    context = multiprocessing.get_context("spawn")
    found = []
    for seed in range(runs):
        with context.Pool(1) as alone, context.Pool(1) as other:
            one = alone.apply(measure, (name, agents, seed, False))
            found.append(one._replace(traced=other.apply(measure, (name, agents, seed, True)).traced))
    return Memory(*map(median, zip(*found, strict=True)))


def main() -> None:
    agents, runs = (int(sys.argv[place]) if len(sys.argv) > place else usual for place, usual in ((1, 300), (2, 5)))
    print(f"{PROBLEM}, {agents} agents, {BUDGET:,} evaluations, medians of {runs} searches")
    print(f"{'optimizer':<14}{'process before, MB':>20}{'resident, kB':>14}{'arrays and objects, kB':>24}")
    for name in OPTIMIZERS:
        found = medians(name, agents, runs)
        print(f"{name:<14}{found.before / 1e3:>20.0f}{found.resident:>14,.0f}{found.traced:>24,.0f}", flush=True)


if __name__ == "__main__":
    main()
