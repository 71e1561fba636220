"""What isolation costs: a trial without its search, a call where the problem is apart, and the memory of a job.

One job makes trials of a tiny budget, which are all overhead, in several ways: in a process that makes several (the
default, where trials are short), in a process forked for every trial (the default, where trials take 0.1 s), with the
problem in another process (as a verification makes them), and, where bubblewrap can be used, as code that nobody
trusts. Then the cost of a call of the objective whose problem is in another process is measured against the default,
and the memory of the job's processes: the pages that they share are counted once (proportional set size).
"""

import shutil
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path
from statistics import median
from time import perf_counter

import psutil
from _rows import Rows, main, short, times

from bench import Study
from bench.execution import job
from bench.execution.job import Task
from bench.execution.supervisor import Supervisor

DEFAULT = job.WORTH
WAYS = (
    ("several trials per process", DEFAULT, {}), ("a fork for each", 0.0, {}),
    ("the problem in another process", 0.0, {"apart": True}), ("untrusted", 0.0, {"untrusted": True}),
)  # fmt: skip
SMALL = {"name": "small", "trials": 1, "budget": 10, "problems": [{"name": "signature-12"}],
         "optimizers": [{"name": "random-search", "agents": 10}]}  # fmt: skip


def measure(quick: bool) -> Rows:
    trials, calls = (10, 100) if quick else (200, 3000)
    thesis = Study.load("thesis")
    rows = []
    for what, study in (
        ("10 evaluations", Study.from_dict(SMALL)),
        (
            "the thesis study, cut to 300 evaluations",
            replace(thesis.override(budget=300), problems=thesis.problems[:2]),
        ),
    ):
        ways = [way for way in WAYS if "untrusted" not in way[2] or shutil.which("bwrap")]
        found = [overhead(study.override(trials=trials), *way[1:]) for way in ways]
        for (how, *_), (ms, memory) in zip(ways, found, strict=True):
            value = f"{short(ms)} ms, {times(ms / found[0][0])} the first way; {memory:.0f} MB a job"
            rows.append((f"a trial without its search, {what}: {how}", value))
    for optimizer, agents, what in (("random-search", 1, "one point"), ("random-search", 300, "300 points")):
        us = call_cost(optimizer, agents, calls)
        rows.append(
            (f"a call of the objective with {what}: more where the problem is in another process", f"{short(us)} us")
        )
    return rows


def overhead(study: Study, worth: float, mode: dict[str, bool]) -> tuple[float, float]:
    """Return the mean milliseconds of a trial without its search, and the job's memory in MB."""
    job.WORTH = worth
    supervisor, plan = Supervisor(Task(study, **mode)), study.plan()
    try:
        for trial in islice(plan, len(study.problems) * len(study.optimizers)):
            supervisor.make(trial)  # warm
        began, made = perf_counter(), [supervisor.make(trial)["wall_s"] for trial in islice(plan, study.trials)]
        return 1e3 * (perf_counter() - began - sum(made)) / len(made), memory()
    finally:
        supervisor.close()
        job.WORTH = DEFAULT


def memory() -> float:
    """Return the proportional set size of all processes below this one, in MB."""
    held = 0.0
    for process in psutil.Process().children(recursive=True):
        with suppress(OSError):  # of one that has just ended
            text = Path(f"/proc/{process.pid}/smaps_rollup").read_text()
            held += next(float(line.split()[1]) for line in text.splitlines() if line.startswith("Pss:")) / 1e3
    return held


def call_cost(optimizer: str, agents: int, calls: int) -> float:
    """Return the microseconds by which a call of the objective takes longer where the problem is in another process."""
    study = Study.from_dict(
        {"name": "calls", "trials": 6, "budget": calls * agents, "problems": [{"name": "signature-12"}],
         "optimizers": [{"name": optimizer, "agents": agents, "handling": "box"}]}
    )  # fmt: skip
    plain, apart = (Supervisor(Task(study, apart=each)) for each in (False, True))
    try:
        pairs = [[each.make(trial)["wall_s"] for each in (plain, apart)] for trial in study.plan()]
    finally:
        plain.close()
        apart.close()
    return 1e6 * median(two - one for one, two in pairs[1:]) / calls


if __name__ == "__main__":
    main(measure)
