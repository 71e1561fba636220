"""Rules of the budget: a run makes evaluations and ends, having spent the whole budget or declared why not."""

from __future__ import annotations

from bench.check import problems
from bench.check.conformance.recording import RecordedRun
from bench.check.conformance.subject import Subject
from bench.check.conformance.violation import LET_IT_PASS, ConstructionError, ViolationError


def check_run(subject: Subject) -> str:
    """One ordinary run comes to its end."""
    try:
        subject.fresh()
    except Exception as error:  # the rule of the parameters reports it
        raise ConstructionError from error
    run = subject.run(problems.bowl())
    if not len(run.points):
        raise ViolationError("it returned without a single evaluation", "ask objective(x) for the values of points")
    return f"{len(run.points)} evaluations of a function of three variables, ended by: {run.stop}"


def check_budget(subject: Subject) -> str:
    """Any budget is spent completely, or the stop is declared; the objective is not called after the end."""
    agents = subject.fresh().minimum_budget
    budgets = sorted({1, max(1, agents - 1), agents, agents + 1, 3 * agents + 3, 1000})
    stops = set()
    for budget in budgets:
        stops.add(expect_kept_budget(subject.run(problems.bowl(), budget=budget), budget))
    declared = sorted(stops - {"budget"})
    kept = f"kept budgets of {', '.join(map(str, budgets))}"
    return f"{kept}; stopped early and declared: {'; '.join(declared)}" if declared else f"{kept} to the evaluation"


def expect_kept_budget(run: RecordedRun, budget: int, where: str = "") -> str:
    """Return why the run ended; raises ViolationError unless it was by the budget or by a declared stop."""
    if run.asked_after:
        raise ViolationError(
            f"it called the objective {run.asked_after} more time{'s' * (run.asked_after > 1)} after the "
            f"budget of {budget} was spent{where}",
            LET_IT_PASS,
        )
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
