"""The rule of the leader: later moves depend on the values that are found, not on those of the first generation alone.

A run is made again with the value of one point far below all others. A method that learns moves otherwise from then
on: one that follows its best point with all points, differential evolution with those that draw on this one. Where such
a value changes points when it is of the first generation, and none later, or none but those of the same agent, a leader
or values are stale. Random search and chains that are independent take no notice of either, and pass.
"""

from __future__ import annotations

import numpy as np

from bench.check.conformance.recording import ViolationError
from bench.check.conformance.subject import Subject
from bench.check.problems import bowl, spiked

GENERATIONS, NEXT = 16, 3
LATER = 7  # points whose value is changed after the first generation
NOTICED = 0.3  # share of points that a leader changes at least
OWN = 1.5  # agents that one agent may be, by chance


def check_leader(subject: Subject) -> str:
    """A value far below all others changes later points, in every generation as in the first."""
    agents, problem = subject.fresh().minimum_budget, bowl()
    subject.run(problem, budget=20 * GENERATIONS)
    size = max(agents, problem.first_batch)
    budget = GENERATIONS * max(size, 20)
    length = NEXT * size if problem.first_batch >= agents > 1 else budget  # else nothing shows a generation
    plain = problem.share(subject.run(budget=budget).points)
    _, new = np.unique(plain, axis=0, return_index=True)
    new = np.sort(new[(new >= size) & (new < (3 * size if size > 1 else len(plain) // 2))])
    if len(new) < LATER:
        return "not judged: it evaluates few points, or the same ones"

    def share(at: int) -> float:
        other = problem.share(subject.run(spiked(plain[at]), budget=budget).points)
        start, end = (at // size + 1) * size, min(len(plain), len(other))
        after = slice(start, min(end, start + length))
        return float((plain[after] != other[after]).any(axis=1).mean()) if end > start else 1.0

    early = max(share(at) for at in {0, size // 2, size - 1})
    late = max(share(int(at)) for at in new[np.linspace(0, len(new) - 1, LATER).astype(int)])
    if (early and not late) or (size > 1 and early >= NOTICED and late < OWN / size):
        raise ViolationError(
            f"a value far below all others changes at most {late:.0%} of the points after it, and {early:.0%} where it "
            "is one of the first generation",
            "compare every new value with the best one so far, and keep point and value where it is better",
        )
    return f"a value far below all others changes up to {late:.0%} of the points after it"
