"""Measure the memory of a search: how much each thesis optimizer needs above the process that runs it.

A fresh process for each search loads all that the optimizer needs and makes a search with the fewest agents, so that
everything is imported and compiled; then the memory in use is the baseline, and the peak of the search itself is
measured above it (VmHWM less VmRSS, in pages of 4 kB; Linux only). Medians over seeds. random-search shows what the
harness itself takes: its trace, and one generation of points.
"""

import ctypes
import gc
import multiprocessing
from contextlib import suppress
from pathlib import Path
from statistics import median

from _rows import Rows, main, short

import bench

PROBLEM, AGENTS = "signature-12", 300
OPTIMIZERS = {
    "random-search": {}, "gwo": {}, "da": {}, "alo": {}, "goa": {}, "cma-es": {"handling": "box", "start": "midpoint"},
}  # fmt: skip
FEWEST = 5  # agents that every optimizer accepts
STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def measure(quick: bool) -> Rows:
    budget, seeds = (3_000, 1) if quick else (60_000, 3)
    rows = []
    for name in OPTIMIZERS:
        found = []
        for seed in range(seeds):
            with multiprocessing.get_context("spawn").Pool(1) as fresh:
                found.append(fresh.apply(memory, (name, budget, seed)))
        before, peak = (median(each) for each in zip(*found, strict=True))
        what = f"peak memory of a search of {name} above its process, {AGENTS} agents, {budget:,} evaluations"
        rows.append((what, f"{short(peak)} MB; the process itself {before:.0f} MB"))
    return rows


def memory(name: str, budget: int, seed: int) -> tuple[float, float]:
    """Return the MB of this process, which must be fresh, before a search, and the search's peak above them."""
    problem = bench.load_problem(PROBLEM)
    few, many = (bench.load_optimizer(name, agents=agents, **OPTIMIZERS[name]) for agents in (FEWEST, AGENTS))
    bench.solve(problem, few, budget=20 * FEWEST, seed=seed)
    gc.collect()
    with suppress(OSError, AttributeError):  # glibc only: a search would reuse, unseen, what loading has freed
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    before = resident("VmRSS")
    RESET.write_text("5", encoding="ascii")  # sets the peak back to what is resident now
    bench.solve(problem, many, budget=budget, seed=seed)
    return before, resident("VmHWM") - before


def resident(field: str) -> float:
    """Return VmRSS (now) or VmHWM (peak) of this process in MB."""
    lines = STATUS.read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) / 1e3 for line in lines if line.startswith(f"{field}:"))


if __name__ == "__main__":
    main(measure)
