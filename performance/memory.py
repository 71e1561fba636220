"""Measure the memory of a search: how much each thesis optimizer needs above the process that runs it.

A fresh process for each search loads all that the optimizer needs and makes a search with the fewest agents, so that
everything is imported and compiled; then the memory in use is the baseline, and the peak of the search itself is
measured above it (VmHWM less VmRSS, in pages of 4 kB; Linux only). Medians over seeds. random-search shows what the
harness itself takes: its trace, and one generation of points.
"""

import ctypes
import gc
import multiprocessing
import tracemalloc
from contextlib import suppress
from pathlib import Path
from statistics import median

from _rows import Rows, main, short

import bench

PROBLEM = "signature-12"
OPTIMIZERS = {
    "random-search": {}, "gwo": {}, "da": {}, "alo": {}, "goa": {}, "cma-es": {"handling": "box", "start": "midpoint"},
}  # fmt: skip
FEWEST = 5  # agents that every optimizer accepts
STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def measure(quick: bool) -> Rows:
    budget, seeds, sizes = (3_000, 1, (300,)) if quick else (60_000, 3, (300, 30))
    rows = []
    for agents in sizes:
        for name in OPTIMIZERS:
            found = [apart(name, agents, budget, seed) for seed in range(seeds)]
            before, resident = (median(each) for each in zip(*found, strict=True))
            traced = apart(name, agents, budget, 0, True)[1]  # of one search: it hardly differs
            what = f"peak memory of a search of {name} above its process, {agents} agents, {budget:,} evaluations"
            value = f"{short(resident)} MB, arrays and objects {short(traced)} MB; the process itself {before:.0f} MB"
            rows.append((what, value))
    return rows


def apart(*arguments: object) -> tuple[float, float]:
    """Return :func:`memory` of a fresh process."""
    with multiprocessing.get_context("spawn").Pool(1) as fresh:
        found: tuple[float, float] = fresh.apply(memory, arguments)
    return found


def memory(name: str, agents: int, budget: int, seed: int, trace: bool = False) -> tuple[float, float]:
    """Return the MB of this process, which must be fresh, before a search, and the search's peak above them.

    With ``trace`` the peak is that of what Python and numpy allocate, without compiled code's own arrays.
    """
    problem = bench.load_problem(PROBLEM)
    few, many = (bench.load_optimizer(name, agents=agents, **OPTIMIZERS[name]) for agents in (FEWEST, agents))
    bench.solve(problem, few, budget=20 * FEWEST, seed=seed)
    gc.collect()
    with suppress(OSError, AttributeError):  # glibc only: a search would reuse, unseen, what loading has freed
        ctypes.CDLL("libc.so.6").malloc_trim(0)
    before = resident("VmRSS")
    if trace:
        tracemalloc.start()
    else:
        RESET.write_text("5", encoding="ascii")  # sets the peak back to what is resident now
    bench.solve(problem, many, budget=budget, seed=seed)
    return before, tracemalloc.get_traced_memory()[1] / 1e6 if trace else resident("VmHWM") - before


def resident(field: str) -> float:
    """Return VmRSS (now) or VmHWM (peak) of this process in MB."""
    lines = STATUS.read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) / 1e3 for line in lines if line.startswith(f"{field}:"))


if __name__ == "__main__":
    main(measure)
