"""Estimate how long a study takes before its first trial, from few evaluations, none of which takes a second."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from bench.execution import trial_process
from bench.execution.job import LOADING, Task, root
from bench.execution.plan import EXPENSIVE, Plan
from bench.execution.runner import run
from bench.helpers.text import count
from bench.sandbox.process import FAILURES, TimeExceededError
from bench.storage.folder import Folder
from bench.study import Study

PROBLEMS = 3
SHARE = 20  # of the budget that a short trial has, as 1 / SHARE
LEAST = 1_000  # evaluations of a short trial, where the budget has as many
LONGEST = 60.0  # seconds of a short trial, which fails where it takes longer
_CHEAP = 1e-3  # seconds of an evaluation up to which the time of the optimizer counts, so that short trials are made


class TimeEstimate(NamedTuple):
    """How long a plan's trials take on one processor, and how that is known.

    Attributes:
        seconds: None where it is not known.
        source: in words, from what; or why it is not known.
    """

    seconds: float | None
    source: str


def estimated(plan: Plan, n_jobs: int, untrusted: bool = False) -> TimeEstimate:
    """Return how long a plan's trials will take, one point at a time.

    Up to three problems, at equal steps, are evaluated at one point twice. Where an evaluation takes more than a
    millisecond, it alone counts. Else each optimizer makes two trials with a twentieth of the budget on each of them;
    the faster one counts, as code may be compiled in the first, and the time of a trial is taken as proportional to its
    evaluations. An optimizer whose short trials fail, as where its population exceeds their budget or they take longer
    than a minute, counts as the mean of the others.

    Args:
        plan: of a study.
        n_jobs: trials made at a time.
        untrusted: make the evaluations in a sandbox.
    """
    study = plan.study
    step = max(1, (len(study.problems) - 1) // (PROBLEMS - 1))
    some = replace(study, problems=study.problems[::step][:PROBLEMS])
    probed = _probed(some, untrusted)
    if isinstance(probed, str):
        return TimeEstimate(None, probed)
    if max(probed.values()) <= _CHEAP:
        return _from_short_trials(plan, some, n_jobs, untrusted)
    each = sum(probed.values()) / len(probed)
    source = f"{each:.3g} s an evaluation, in {count(2 * len(probed), 'evaluation')} on some of the problems"
    evaluations = _evaluations(plan)
    return TimeEstimate(plan.total(lambda problem, _: probed.get(problem, each) * evaluations[problem]), source)


def _evaluations(plan: Plan) -> dict[str, int]:
    """Return the evaluations of a trial on each problem."""
    study = plan.study
    return {label: study.evaluations(study.problem(label).dimension) for label in {p for p, _ in plan.counts()}}


def _probed(study: Study, untrusted: bool) -> dict[str, float] | str:
    """Return the seconds of an evaluation of each problem, or in words why they are not known."""
    task = Task.of(study, untrusted)
    found: dict[str, float] = {}
    with root(task) as server:
        server.call(trial_process.begin, *task.beginning, seconds=LOADING)
        for entry in study.problems:
            server.call(trial_process.load_problem, entry.label, seconds=LOADING)
            process = server.process()
            try:
                for _ in range(2):  # the first may import what it needs
                    found[entry.label] = float(process.call(trial_process.probe, entry.label, seconds=EXPENSIVE))
                process.close()
            except TimeExceededError:
                return (
                    f"an evaluation of {entry.label} takes more than {EXPENSIVE:g} s, so it was ended and no other was "
                    "made"
                )
            except FAILURES as error:
                return f"an evaluation of {entry.label} failed: {error}"
    return found


def _from_short_trials(plan: Plan, some: Study, n_jobs: int, untrusted: bool) -> TimeEstimate:
    study = plan.study
    short = replace(some, trials=2, budget=study.budget.shortened(SHARE, LEAST))
    with TemporaryDirectory() as place:
        made = run(short, Path(place) / "short", n_jobs=n_jobs, timeout=LONGEST, untrusted=untrusted, verify=False)
        folder = Folder(made.folder)
        rows = [row for row in folder.store.rows() if row["status"] == "ok" and row["nfev"]]
    if not rows:
        return TimeEstimate(None, "the short trials for it failed")
    fastest: dict[str, dict[str, float]] = {}  # by optimizer and problem
    for row in rows:
        speeds = fastest.setdefault(row["optimizer"], {})
        speeds[row["problem"]] = min(row["wall_s"] / row["nfev"], speeds.get(row["problem"], LONGEST))
    means = {label: sum(speeds.values()) / len(speeds) for label, speeds in fastest.items()}
    usual = sum(means.values()) / len(means)
    evaluations = _evaluations(plan)
    total = plan.total(lambda problem, optimizer: means.get(optimizer, usual) * evaluations[problem])
    spent = count(sum(row["nfev"] + 1 for row in rows), "evaluation")
    return TimeEstimate(total, f"short trials on some of the problems, {spent}")
