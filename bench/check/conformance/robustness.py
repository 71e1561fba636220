"""Rules of robustness: a run comes to its end with any budget, box, number of variables and objective values."""

from __future__ import annotations

import dataclasses

import numpy as np

from bench.check import problems
from bench.check.conformance.recording import LET_IT_PASS, RecordedRun, ViolationError
from bench.check.conformance.subject import Subject, ordinary_budget
from bench.check.problems import RecordingProblem
from bench.sandbox.messages import describe_error

CLIP = (
    "clip to objective.lower and objective.upper, or call objective.repair(x), as the last step before objective(x): "
    "mapping points back from a unit cube can leave the box by rounding"
)
GUARD = "guard divisions by ranges or sums of values: they can be zero or infinite"


def check_run(subject: Subject) -> str | None:
    """One ordinary run comes to its end."""
    try:
        subject.fresh()
    except Exception:  # the rule of the parameters reports it
        return None
    run = subject.run()
    if not len(run.points):
        raise ViolationError("it returned without a single evaluation", "ask objective(x) for the values of points")
    return f"{len(run.points)} evaluations of a function of three variables, ended by: {run.stop}"


def check_budget(subject: Subject) -> str:
    """Any budget is spent completely, or the stop is declared; the objective is not called after the end."""
    agents = subject.fresh().minimum_budget
    budgets = sorted({1, max(1, agents - 1), agents, agents + 1, 3 * agents + 3, 1000})
    stops = {_expect_kept_budget(subject.run(budget=budget), budget) for budget in budgets}
    problem = problems.bowl()
    subject.run(problem, budget=3 * agents + 3)
    if problem.first_batch == agents + 1 > 2:
        raise ViolationError(
            f"its first generation has {agents + 1} points, one more than its population of {agents}",
            "let the first generation have as many points as agents says",
        )
    declared = sorted(stops - {"budget"})
    kept = f"kept budgets of {', '.join(map(str, budgets))}"
    return f"{kept}; stopped early and declared: {'; '.join(declared)}" if declared else f"{kept} to the evaluation"


def check_box(subject: Subject) -> str:
    """No point lies outside the box, even where the box is uneven and narrow and its optimum in a corner."""
    problem, optimizer = problems.corner(), subject.fresh()
    run = subject.run(problem, instance=optimizer, budget=4 * ordinary_budget(optimizer))
    outside = run.points[~((run.points >= problem.lower) & (run.points <= problem.upper)).all(axis=1)]
    if len(outside):
        raise ViolationError(
            f"{len(outside)} of {len(run.points)} points lie outside the box, such as {outside[0].tolist()} in the box "
            f"from {problem.lower.tolist()} to {problem.upper.tolist()}; each costs an evaluation and is worth +inf",
            GUARD if not np.isfinite(run.points).all() else CLIP,
        )
    return f"{len(run.points)} points, none outside a narrow and uneven box far from the origin"


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
        if bad := int((~np.isfinite(run.points)).any(axis=1).sum()):
            raise ViolationError(f"it asked for {bad} points that are not finite with {name}", GUARD)
    return f"runs with {', '.join(problems.odd())}"


def _each(subject: Subject, problem: RecordingProblem, where: str) -> RecordedRun:
    """Return a run that kept its budget; raises ViolationError for any other, with the place in its message."""
    optimizer = subject.fresh()
    try:
        run = subject.run(problem, instance=optimizer)
    except (Exception, SystemExit) as error:
        raise ViolationError(f"it raised {describe_error(error)}{where}", "") from error
    if run.stop == "undeclared" and subject.run().stop != run.stop:  # else the budget's rule reports it
        _expect_kept_budget(dataclasses.replace(run, asked_after=0), ordinary_budget(optimizer), where)
    return run


def _expect_kept_budget(run: RecordedRun, budget: int, where: str = "") -> str:
    """Return why the run ended; raises ViolationError unless it was by the budget or by a declared stop."""
    if run.asked_after:
        times = f"{run.asked_after} more time{'s' * (run.asked_after > 1)}"
        finding = f"it called the objective {times} after the budget of {budget} was spent{where}"
        raise ViolationError(finding, LET_IT_PASS)
    if not len(run.points):
        raise ViolationError(
            f"it returned without a single evaluation of a budget of {budget}{where}",
            "evaluate also where the budget is below one generation: loop until the budget ends the run",
        )
    if run.stop == "undeclared":
        raise ViolationError(
            f"it returned after {len(run.points)} of {budget} evaluations{where} and declared no reason",
            "loop until the budget ends the run, or draw the last batch from objective.remaining; declare a "
            'criterion of your own with objective.stop("reason")',
        )
    return run.stop
