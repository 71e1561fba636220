"""Rules of robustness: runs handle any box, any number of variables and any objective values."""

from __future__ import annotations

import dataclasses

import numpy as np

from bench.check import problems
from bench.check.conformance.budget import expect_kept_budget
from bench.check.conformance.recording import RecordedRun
from bench.check.conformance.subject import Subject, ordinary_budget
from bench.check.conformance.violation import ViolationError
from bench.problem import FunctionProblem
from bench.sandbox.messages import describe_error

CLIP = (
    "clip to objective.lower and objective.upper, or call objective.repair(x), as the last step before objective(x): "
    "mapping points back from a unit cube can leave the box by rounding"
)
GUARD = "guard divisions by ranges or sums of values: they can be zero or infinite"


def check_box(subject: Subject) -> str:
    """No point lies outside the box, even where the box is uneven and narrow and its optimum in a corner."""
    problem, optimizer = problems.corner(), subject.fresh()
    run = subject.run(problem, optimizer=optimizer, budget=4 * ordinary_budget(optimizer))
    if run.outside:
        inside = ((run.points >= problem.lower) & (run.points <= problem.upper)).all(axis=1)
        raise ViolationError(
            f"{run.outside} of {len(run.points)} points lie outside the box, such as "
            f"{run.points[~inside][0].tolist()} in the box from {problem.lower.tolist()} to {problem.upper.tolist()}; "
            f"each costs an evaluation and is worth +inf",
            GUARD if not np.isfinite(run.points).all() else CLIP,
        )
    return f"{len(run.points)} points, none outside a narrow and uneven box far from the origin"


def check_repair(subject: Subject) -> str:
    """A problem may restrict points further than its box; the share of such points is reported and not judged."""
    problem = problems.half()
    run = subject.run(problem)
    share = float((problem.repair(run.points) != run.points).any(axis=1).mean())
    if not share:
        return "all points are feasible by the problem's own repair"
    return f"{share:.0%} of the points are infeasible by the problem's own repair (it may use objective.repair(x))"


def check_dimensions(subject: Subject) -> str:
    """Problems of any dimension are handled."""
    dimensions = (1, 2, 7, 50)
    for dimension in dimensions:
        _each(subject, problems.bowl(dimension), f" in {dimension} dimension{'s' * (dimension > 1)}")
    return f"runs in {', '.join(map(str, dimensions))} dimensions"


def check_values(subject: Subject) -> str:
    """Any values are handled: equal, infinite, huge, tiny and negative ones; NaN reaches an optimizer as +inf."""
    for name, problem in problems.odd().items():
        run = _each(subject, problem, f" with {name}")
        bad = int((~np.isfinite(run.points)).any(axis=1).sum())
        if bad:
            raise ViolationError(
                f"it asked for {bad} points that are not finite with {name}",
                GUARD,
            )
    return f"runs with {', '.join(problems.odd())}"


def _each(subject: Subject, problem: FunctionProblem, where: str) -> RecordedRun:
    """Return a run that kept its budget; raises ViolationError, saying where, for one that did not or that raised."""
    optimizer = subject.fresh()
    try:
        run = subject.run(problem, optimizer=optimizer)
    except (Exception, SystemExit) as error:
        raise ViolationError(f"it raised {describe_error(error)}{where}", "") from error
    if run.stop == "undeclared" and subject.run(problems.bowl()).stop != run.stop:  # else the budget's rule reports it
        expect_kept_budget(dataclasses.replace(run, asked_after=0), ordinary_budget(optimizer), where)
    return run
