"""The trials of a study as they are compared: instances of a function pooled, at budgets that all had."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import pandas as pd

from bench import analysis
from bench.analysis.cells import labels, variables
from bench.analysis.comparable import Comparable, comparable
from bench.study import Entry, Study
from bench.study.budget import Budget


@dataclass(frozen=True)
class Compared:
    """The trials of a study; every frame has the cells of the study in the study's order."""

    results: Any  # bench.Results, which is made of this class, too

    @cached_property
    def pooled(self) -> analysis.Pooled:
        """The trials with the instances of each function pooled; a study without instances stays as it is."""
        names = [entry.label for entry in self.results.study.problems]
        facts = {label: self.results.facts(label) for label in names}
        optima = {label: of_problem.optimum for label, of_problem in facts.items() if of_problem.optimum is not None}
        features = {label: of_problem.features for label, of_problem in facts.items()}
        return analysis.pool_instances(self.results.frame, self.results.traces, names, features, optima)

    @cached_property
    def study(self) -> Study:
        """The study as it is compared: a function in a dimension is one problem, whose trials are by instance."""
        entries = {entry.label: entry for entry in self.results.study.problems}
        problems = tuple(entries.get(label) or Entry(label, label) for label in self.pooled.members)
        study: Study = self.results.study
        return replace(study, problems=problems)

    @cached_property
    def whole(self) -> pd.DataFrame:
        """The tidy frame with problems and optimizers as categories, and instances pooled."""
        return analysis.in_study_order(self.pooled.frame, self.study)

    @cached_property
    def comparable(self) -> Comparable:
        """The trials that are compared, and what is left out."""
        return comparable(self.whole, self.traces, self.allowed, self.study.imported)

    @property
    def frame(self) -> pd.DataFrame:
        """The frame whose values are ranked and tested: the whole one, or what of it can be compared."""
        return self.comparable.frame

    @property
    def traces(self) -> analysis.Traces:
        """The traces of its trials."""
        return self.pooled.traces

    @cached_property
    def problems(self) -> list[str]:
        """The labels of the problems that have at least one trial."""
        return [label for label in labels(self.whole, "problem") if (self.whole["problem"] == label).any()]

    @cached_property
    def dimensions(self) -> dict[str, int]:
        """The number of search variables of each problem, as far as a trial or the problem shows it."""
        shown = {str(label): len(variables(trials)) for label, trials in self.whole.groupby("problem", observed=True)}
        return {
            label: number
            for label in self.problems
            if (number := shown[label] or self.results.dimension(self.pooled.members[label][0]))
        }

    @cached_property
    def budgets(self) -> dict[str, int]:
        """The evaluations that a trial on each problem was allowed."""
        return self._evaluations(self.results.study.budget)

    def _evaluations(self, budget: Budget) -> dict[str, int]:
        """Return the evaluations of a budget on each problem, the most of any where its dimension is not known."""
        if budget.number:
            return dict.fromkeys(self.problems, budget.number)
        known = {label: budget.evaluations(dimension) for label, dimension in self.dimensions.items()}
        return {label: known.get(label, max(known.values(), default=1)) for label in self.problems}

    @cached_property
    def allowed(self) -> analysis.Budgets:
        """The evaluations that a trial was allowed: by problem, or by problem and optimizer where budgets differ."""
        budgets = self.results.budgets
        if all(budget == self.results.study.budget for budget in budgets.values()):
            return self.budgets
        by_optimizer = {optimizer: self._evaluations(budget) for optimizer, budget in budgets.items()}
        return {(label, optimizer): most[label] for label in self.problems for optimizer, most in by_optimizer.items()}
