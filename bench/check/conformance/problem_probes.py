"""The rules of a problem that take many calls: its resolution, its variables, its batches, and a search for less."""

from __future__ import annotations

from time import monotonic

import numpy as np

from bench.check.conformance.problem_subject import ProblemSubject, feasible_values, rounded, sample, true_values
from bench.check.conformance.recording import ViolationError
from bench.contract.objective import integer_flags, repaired
from bench.contract.problem import Problem
from bench.contract.typing import Floats
from bench.helpers.text import count, listed
from bench.trial.scoring.problem import violations_of

SECONDS = 3.0
"""A slow problem gets fewer calls than :data:`CALLS` and :data:`LARGEST` say."""

CALLS, LARGEST = 5_000, 256
FINE, COARSE, RESOLVED = 1e-10, 1e-4, 1e-13
"""Steps, as shares of the box: one between the resolutions of float64 and float32, and one above both; and the change,
as a share of the value, that is no rounding."""
POINTS = 64

GENERATIONS = 40


def check_resolution(subject: ProblemSubject) -> str:
    """Values resolve steps of every variable that float32 does not."""
    problem = subject.fresh()
    x, flags = sample(problem, POINTS, subject.seed), integer_flags(problem)
    values = true_values(problem, x)
    least, until = 1.0, monotonic() + SECONDS
    for place in [None, *np.flatnonzero(~flags)]:  # all variables, then one after the other
        step = np.where(flags, 0.0, problem.upper - problem.lower)
        if place is not None:
            step[np.arange(len(step)) != place] = 0.0
        step = np.where(x > (problem.lower + problem.upper) / 2, -step, step)
        coarse = true_values(problem, x + COARSE * step) - values
        fine = true_values(problem, x + FINE * step) != values
        with np.errstate(invalid="ignore"):
            expected = np.abs(coarse) * FINE / COARSE > RESOLVED * np.abs(values)
        if expected.sum() >= POINTS / 4:
            least = min(least, share := float(fine[expected].mean()))
            if share < 0.2:
                name = "every variable" if place is None else problem.variables[place]
                raise ViolationError(
                    f"a step of {COARSE:g} of the box in {name} changes {np.mean(coarse != 0):.0%} of the values, one "
                    f"of {FINE:g} {share:.0%}: as where numbers pass through float32",
                    "compute in float64 throughout: no float32 array, and no rounding of points or values",
                )
        if monotonic() > until:
            break
    return f"a step of {FINE:g} of the box changes at least {least:.0%} of the values"


def check_variables(subject: ProblemSubject) -> str:
    """Every variable changes a value or a violation at some point."""
    problem = subject.fresh()
    x, others = sample(problem, 32, subject.seed), sample(problem, 32, subject.seed + 1)
    if problem.optimum_point is not None:
        x[:8] = problem.optimum_point
    before = _answers(problem, x)
    if len(np.unique(before, axis=0)) < len(x) / 2:
        return "not judged: most points have equal values"
    idle = []
    for place, name in enumerate(problem.variables):
        changed = x.copy()
        changed[:, place] = others[:, place]
        if np.array_equal(_answers(problem, changed), before, equal_nan=True):
            idle.append(str(name))
    if idle:
        raise ViolationError(
            f"no value or violation of {len(x)} points changes with {listed(idle)}",
            "use every variable, or leave it out",
        )
    return f"each of {count(len(problem.variables), 'variable')} changes a value or a violation"


def _answers(problem: Problem, x: Floats) -> Floats:
    return np.column_stack([true_values(problem, x), violations_of(problem, x)])


def check_calls(subject: ProblemSubject) -> str:
    """A point has the same bits in a batch of any size, and after thousands of calls."""
    problem, rng = subject.fresh(), np.random.default_rng(subject.seed)
    x = sample(problem, LARGEST, subject.seed)
    first, until, calls = true_values(problem, x), monotonic() + SECONDS, 0
    for size in (*(rng.permutation(LARGEST) + 1), *[1] * CALLS):
        calls += 1
        if not np.array_equal(true_values(problem, x[:size]), first[:size], equal_nan=True):
            raise ViolationError(
                f"after {count(calls, 'call')}, in a batch of {size}, a point has another value than in one of "
                f"{LARGEST}",
                "compute a value from the point alone, however many are asked for and were before",
            )
        if monotonic() > until:
            break
    return f"a point has the same bits in {count(calls, 'call')}, in batches of up to {LARGEST} in random order"


def improved(problem: Problem, start: Floats, seed: int) -> tuple[Floats, float]:
    """Search from a point in steps of all lengths; return the best (d,) point found and its value."""
    rng, flags, width = np.random.default_rng(seed), integer_flags(problem), problem.upper - problem.lower
    best, value = start, float(feasible_values(problem, start[None])[0])
    for _ in range(GENERATIONS):
        lengths = 10.0 ** rng.uniform(-5, -0.5, (32, 1))
        moved = rng.random((32, len(start))) < np.where(np.arange(32) % 2, 1.0, 2 / len(start))[:, None]
        steps = lengths * width * rng.standard_normal((32, len(start))) * moved
        x = rounded(repaired(problem, np.clip(best + steps, problem.lower, problem.upper)), flags)
        values = feasible_values(problem, x)
        if values.min() < value:
            best, value = x[values.argmin()], float(values.min())
    return best, value
