"""Compute the statistics of a study once for all sections of its report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import pandas as pd

from bench import analysis
from bench.analysis.integrity import undeclared
from bench.execution.descriptions import Description, describe
from bench.execution.matched import Matched, matched
from bench.report.findings.anytime import Anytime
from bench.report.findings.final import COLOURED, CROWD, MANY_OPTIMIZERS
from bench.report.findings.trials import MANY_PROBLEMS
from bench.report.methods import Methods, MethodsFacts, methods
from bench.study.budget import described

__all__ = ["COLOURED", "CROWD", "MANY_OPTIMIZERS", "MANY_PROBLEMS", "Findings"]


@dataclass(frozen=True)
class Findings(Anytime):
    """The analysis of a study; every frame has the cells of the study in the study's order."""

    @cached_property
    def integrity(self) -> pd.DataFrame:
        """The checks of the results themselves, of which instances are problems of their own."""
        study, results = self.results.study, self.results
        members = {label: self.pooled.members[label] for label in self.problems}
        budgets: analysis.Budgets = {each: self.budgets[label] for label, own in members.items() for each in own}
        if self.allowed != self.budgets:
            cells = cast("Mapping[tuple[str, str], int]", self.allowed)
            budgets = {(each, optimizer): most for (label, optimizer), most in cells.items() for each in members[label]}
        facts = {each: results.facts(each) for own in members.values() for each in own}
        pool = {each: label for label, own in self.pooled.members.items() for each in own}
        frame = analysis.in_study_order(results.frame, study)
        return analysis.integrity(
            frame.assign(pool=frame["problem"].astype(object).map(pool)),
            study_budget=study.budget if isinstance(study.budget, int) and self.allowed == self.budgets else budgets,
            planned_trials={
                (entry.label, label): self.decisions.stopped.get((entry.label, label), trials)
                for entry in study.problems
                for label, trials in results.planned.items()
            },
            traces=results.traces,
            boxes={label: each.continuous for label, each in facts.items() if each.box},
            diagnoses=self.results.checks,
            verifications=self.results.verifications,
            stores=self.results.stores,
            extensions=self.extensions,
        )

    @cached_property
    def descriptions(self) -> dict[str, Description]:
        """The optimizers and controls as their plug-ins describe them here, by label."""
        return describe(self.study, self._sandbox)

    @cached_property
    def matched(self) -> list[Matched]:
        """The conditions that optimizers of the study have, each with all algorithms; none of several folders."""
        return [] if len(self.results.paths) > 1 else matched(self.study, self.descriptions, self._sandbox)

    @property
    def _sandbox(self) -> str | None:
        """The sandbox in which the study was run."""
        return next(filter(None, (record.get("sandbox") for record in self.results.environments)), None)

    @cached_property
    def methods(self) -> Methods:
        """The methods section of a paper about this run."""
        study, pairs, early = self.study, self.pairs, analysis.stopped_early(self.frame)
        return methods(
            MethodsFacts(
                study=study,
                replications=self.replications,
                known=self.known,
                empty=int((self.coverage["stored"] == 0).sum()),
                failed=int(self.coverage["failed"].sum()),
                descriptions=self.descriptions,
                environments=self.results.environments,
                tests=len(pairs) if self.levels.problems else 0,
                pairs=len(pairs),
                levels=self.levels,
                blocks=len({self.blocks[str(label)] for label in self.medians.index}),
                permutation_tests=int(pairs["ks_tied"].sum()),
                ranked_problems=len(self.medians),
                known_optima=int(self.targets.drop_duplicates("problem")["known"].sum()),
                targets=self.targets["problem"].nunique(),
                target_set=self.words,
                aocc=self.aocc["problem"].nunique() if self.words.kind == "precisions" else 0,
                early={label: int((early & (self.frame["optimizer"] == label)).sum()) for label in self.optimizers},
                checks=self.results.checks,
                rope=self.rope if len(self.equivalence) else None,
                landscapes=len(self.landscapes.table),
                dominance=self.u_scores["problem"].nunique() if len(self.optimizers) > 1 else 0,
                budgets={label: described(each) for label, each in self.results.budgets.items()},
                common=self.common_words,
                confined=len({problem for (problem, _), by in self.shifts.items() if by}),
                best2009=self.best_times.dropna()["problem"].nunique(),
                tuning=self.study.tuning if self.study.tuning and not self.study.tuning.doubt else None,
                sweeps=sum(not each.levels.empty for each in self.contributions.values()),
                stopped=len(self.decisions.stopped),
                extensions=undeclared(self.extensions),
                needed="" if self.needed.empty else str(self.needed["method"].iloc[0]),
                stability=len(self.stability) > 0,
            )
        )
