"""What isolation costs: a trial beside its search, a call of a strict trial, and the memory of a job.

    python performance/isolation.py [TRIALS]        # default: 200 of each

One job makes trials of a tiny budget, which are all overhead, in several ways: in a process that makes several (the
default, where trials are short), in a process forked for every trial (the default, where trials take 0.1 s), strictly,
and, where bubblewrap can be used, in its sandbox. Then the cost of a call of the objective in a strict trial is
measured against the default, and the memory of the job's processes: the pages that they share are counted once
(proportional set size).
"""

import shutil
import sys
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from statistics import median
from time import perf_counter

import psutil

from bench import Study
from bench.execution import job
from bench.execution.supervisor import Supervisor, Task

CALLS = 3000
DEFAULT = job.WORTH


def main() -> None:
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    thesis = Study.load("thesis")
    small = Study.from_dict(
        {"name": "small", "trials": 1, "budget": 10, "problems": [{"name": "signature-12"}],
         "optimizers": [{"name": "random-search", "agents": 10}]}
    )  # fmt: skip
    for study in (small, replace(thesis.override(budget=300), problems=thesis.problems[:2])):
        for how, worth, strict, sandbox in (
            ("default", DEFAULT, False, None), ("a fork each", 0.0, False, None), ("strict", 0.0, True, None),
            ("bwrap", 0.0, False, "bwrap"), ("strict, bwrap", 0.0, True, "bwrap"),
        ):  # fmt: skip
            if sandbox and not shutil.which(sandbox):
                continue
            job.WORTH = worth
            ms, memory = overhead(study.override(trials=trials), Task(study, strict=strict, sandbox=sandbox))
            print(f"{study.name:<8}{how:<14}{ms:7.2f} ms a trial beside its search; {memory:6.0f} MB a job", flush=True)
    for optimizer, agents in (("random-search", 1), ("random-search", 300)):
        print(
            f"{agents} points a call: {call_cost(optimizer, agents):.1f} us a call more in a strict trial", flush=True
        )


def overhead(study: Study, task: Task) -> tuple[float, float]:
    """Return the mean milliseconds of a trial beside its search, and the job's memory in MB."""
    supervisor, plan = Supervisor(task), study.plan()
    try:
        for _ in supervisor.make(islice(plan, len(study.problems) * len(study.optimizers))):
            pass  # warm
        began, made = perf_counter(), [row["wall_s"] for _, row in supervisor.make(islice(plan, study.trials))]
        return 1e3 * (perf_counter() - began - sum(made)) / len(made), memory()
    finally:
        supervisor.close()


def memory() -> float:
    """Return the proportional set size of all processes below this one, in MB."""
    held = 0.0
    for process in psutil.Process().children(recursive=True):
        with suppress(OSError):  # of one that has just ended
            text = Path(f"/proc/{process.pid}/smaps_rollup").read_text()
            held += next(float(line.split()[1]) for line in text.splitlines() if line.startswith("Pss:")) / 1e3
    return held


def call_cost(optimizer: str, agents: int) -> float:
    """Return the microseconds by which a call of the objective takes longer in a strict trial."""
    study = Study.from_dict(
        {"name": "calls", "trials": 6, "budget": CALLS * agents, "problems": [{"name": "signature-12"}],
         "optimizers": [{"name": optimizer, "agents": agents, "handling": "box"}]}
    )  # fmt: skip
    plain, strict = (Supervisor(Task(study, strict=each)) for each in (False, True))
    try:
        pairs = [[row["wall_s"] for each in (plain, strict) for _, row in each.make([trial])] for trial in study.plan()]
    finally:
        plain.close()
        strict.close()
    return 1e6 * median(two - one for one, two in pairs[1:]) / CALLS


if __name__ == "__main__":
    main()
