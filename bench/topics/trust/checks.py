"""Check the results themselves: budgets, trials, traces, boxes, optima and stores."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import pandas as pd

from bench import analysis
from bench.topics.findings import Findings


def checks(findings: Findings) -> pd.DataFrame:
    """The checks of the results themselves, of which instances are problems of their own."""
    study, results, trials = findings.results.study, findings.results, findings.trials
    members = {label: trials.pooled.members[label] for label in trials.problems}
    budgets: analysis.Budgets = {
        instance: trials.budgets[label] for label, instances in members.items() for instance in instances
    }
    if trials.allowed != trials.budgets:
        cells = cast("Mapping[tuple[str, str], int]", trials.allowed)
        budgets = {
            (instance, optimizer): most for (label, optimizer), most in cells.items() for instance in members[label]
        }
    facts = {instance: results.facts(instance) for instances in members.values() for instance in instances}
    pool = {instance: label for label, instances in trials.pooled.members.items() for instance in instances}
    frame = analysis.in_study_order(results.frame, study)
    return analysis.integrity(
        frame.assign(pool=frame["problem"].astype(object).map(pool)),
        study_budget=(study.budget.number if trials.allowed == trials.budgets else None) or budgets,
        planned_trials={
            (entry.label, label): results.planned_on(label, [entry.label])
            for entry in study.problems
            for label in results.planned
        },
        traces=results.traces,
        boxes={label: of_problem.continuous for label, of_problem in facts.items() if of_problem.box},
        optima={label: of_problem.optimum for label, of_problem in facts.items() if of_problem.optimum is not None},
        diagnoses=results.checks,
        verifications=results.verifications,
        stored=results.stored,
    )
