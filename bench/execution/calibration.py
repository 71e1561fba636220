"""Estimate how long a study takes before its first trial, from short trials on a few of its problems."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.execution.plan import Plan
from bench.execution.runner import run
from bench.storage.folder import Folder

PROBLEMS = 3
SHARE = 20  # of the budget that a short trial has, as 1 / SHARE
LEAST = 1_000  # evaluations of a short trial, where the budget has as many
LONGEST = 60.0  # seconds of a short trial, which fails where it takes longer


def calibrated_seconds(plan: Plan, jobs: int, untrusted: bool = False) -> float | None:
    """Return the seconds on one processor that a plan's trials will take; None where no short trial succeeds.

    Each optimizer makes one trial with a twentieth of the budget on up to three problems, at equal steps. The time of a
    trial is taken as proportional to its evaluations. An optimizer whose short trials fail, as where its population
    exceeds their budget or they take longer than a minute, counts as the mean of the others.
    """
    study = plan.study
    step = max(1, (len(study.problems) - 1) // (PROBLEMS - 1))
    budget = study.budget.shortened(SHARE, LEAST)
    short = replace(
        study, problems=study.problems[::step][:PROBLEMS], trials=1, looks=(), budget=budget, blocks=None, tuning=None
    )
    with TemporaryDirectory() as place:
        made = run(short, Path(place) / "short", n_jobs=jobs, timeout=LONGEST, untrusted=untrusted, verify=False)
        folder = Folder(made.folder)
        rows = [row for row in folder.store.rows() if row["status"] == "ok" and row["nfev"]]
    if not rows:
        return None
    speeds: dict[str, list[float]] = {}
    for row in rows:
        speeds.setdefault(row["optimizer"], []).append(row["wall_s"] / row["nfev"])
    means = {label: sum(measured) / len(measured) for label, measured in speeds.items()}
    usual = sum(means.values()) / len(means)
    evaluations = {label: study.evaluations(study.problem(label).dimension) for label in {p for p, _ in plan.counts()}}
    return plan.total(lambda problem, optimizer: means.get(optimizer, usual) * evaluations[problem])
