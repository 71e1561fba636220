"""The rule of a problem that is kept apart: with it in another process, the run is the same."""

from __future__ import annotations

from dataclasses import replace

from bench.check.conformance.recording import ViolationError
from bench.check.conformance.subject import Subject, ordinary_budget
from bench.check.problems import bowl
from bench.execution.job import Task
from bench.execution.supervisor import make_one
from bench.storage.rows import disagreement
from bench.study import Study


def check_apart(subject: Subject) -> str:
    """Problem, budget and trace in another process change nothing: nothing is evaluated past the objective."""
    remedy = "get values from objective(x) alone, and nothing else of the problem or of the objective's inside"
    budget = ordinary_budget(subject.fresh())
    optimizer = {"name": subject.source, "label": "checked", **subject.options}
    study = Study.from_dict(
        {"name": "apart", "trials": 1, "budget": budget, "seed": subject.seed, "problems": [bowl()],
         "optimizers": [optimizer]}, "of this rule",
    )  # fmt: skip
    trial, task = next(study.plan()), Task.of(study)
    here, there = (make_one(replace(task, apart=apart), trial) for apart in (False, True))
    for row, where in ((here, "in one process"), (there, "with the problem in another process")):
        if row["status"] != "ok":
            raise ViolationError(f"{where}, a trial fails: {row['error']}", remedy)
    if name := disagreement(here, there):
        raise ViolationError(f"with problem and budget in another process, another {name} comes of its run", remedy)
    return f"the problem and the budget of {budget} evaluations in another process change nothing"
