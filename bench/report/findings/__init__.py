"""Compute the statistics of a study once for all sections of its report.

:class:`Findings` holds five parts, each computed from those before it: :class:`Trials` (what was run), :class:`Final`
(what the trials reached at the end), :class:`Anytime` (on the way), :class:`Display` (how much of it is shown) and
:class:`Controls` (the same conditions for all).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import pandas as pd

from bench import analysis
from bench.conditions.descriptions import Descriptions, noted
from bench.conditions.matched import matched
from bench.report.findings.anytime import BEST, Anytime
from bench.report.findings.controls import Controls
from bench.report.findings.display import COLOURED, CROWD, MANY_OPTIMIZERS, Display
from bench.report.findings.final import Final
from bench.report.findings.trials import MANY_PROBLEMS, Trials
from bench.report.landscapes import Landscapes, landscapes
from bench.report.left_out import selection, versions
from bench.results.results import Results
from bench.study import Study
from bench.study.blocks import pooled
from bench.study.rope import Rope
from bench.study.targets import Targets
from bench.study.values import Checked

__all__ = [
    "BEST",
    "COLOURED",
    "CROWD",
    "MANY_OPTIMIZERS",
    "MANY_PROBLEMS",
    "Anytime",
    "Display",
    "Final",
    "Findings",
    "Trials",
]


@dataclass(frozen=True)
class Findings:
    """The analysis of a study; every frame has the cells of the study in the study's order.

    Attributes:
        results: the content of the study's folder.
        asked: targets other than the study's own.
        asked_rope: a region of practical equivalence other than the study's own.
        beside_best: whether the best of 2009 stands beside the optimizers.
        reference: the optimizer that the competition's table compares with each other one.
    """

    results: Results
    asked: Checked[Targets | None] = Checked(Targets.read)
    asked_rope: Checked[Rope | None] = Checked(Rope.read)
    beside_best: bool = False
    reference: str | None = None

    @cached_property
    def trials(self) -> Trials:
        """What was run."""
        return Trials(self.results)

    @cached_property
    def final(self) -> Final:
        """What the trials reached at the end."""
        return Final(self.trials, self.asked_rope)

    @cached_property
    def anytime(self) -> Anytime:
        """What the trials reached on the way."""
        return Anytime(self.trials, self.asked, self.beside_best)

    @cached_property
    def display(self) -> Display:
        """How much of it is shown."""
        return Display(self.trials, self.final)

    @property
    def study(self) -> Study:
        """The study as it is compared."""
        return self.trials.study

    @cached_property
    def selection(self) -> str:
        """Sentences on what the study was selected from, and on versions that are not shown; "" where it is whole."""
        shown = self.results.study
        functions = {pooled(entry.label) for entry in shown.problems}
        sentences = (
            selection(self.results.whole, shown, by_instance=len(functions) < len(self.study.problems)),
            self.versions,
        )
        return " ".join(filter(None, sentences))

    @property
    def versions(self) -> str:
        """A sentence on optimizers that were changed after results of theirs were seen; "" where none was."""
        return versions(self.results.versions)

    @cached_property
    def descriptions(self) -> Descriptions:
        """The optimizers and controls as their plug-ins described them when the study ran, by label."""
        return noted(self.study, self.results.descriptions)

    @cached_property
    def controls(self) -> Controls:
        """The optimizers under each other's conditions, none of several folders."""
        several = len(self.results.paths) > 1
        return Controls(self.trials, self.final, [] if several else matched(self.study, self.descriptions))

    @cached_property
    def landscapes(self) -> Landscapes:
        """The features of the problems' landscapes."""
        members = self.trials.pooled.members
        return landscapes(self.results, {label: members[label][0] for label in self.trials.problems})

    @cached_property
    def integrity(self) -> pd.DataFrame:
        """The checks of the results themselves, of which instances are problems of their own."""
        study, results, trials = self.results.study, self.results, self.trials
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
                (entry.label, label): trials.decisions.stopped.get(
                    (entry.label, label), results.planned_on(label, [entry.label])
                )
                for entry in study.problems
                for label in results.planned
            },
            traces=results.traces,
            boxes={label: of_problem.continuous for label, of_problem in facts.items() if of_problem.box},
            optima={label: of_problem.optimum for label, of_problem in facts.items() if of_problem.optimum is not None},
            diagnoses=results.checks,
            verifications=results.verifications,
            stores=results.stores,
            extensions=trials.extensions,
        )
