"""Compute the statistics of a study once for all sections of its report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import pandas as pd

from bench import analysis
from bench.budget import evaluations
from bench.execution.citations import bibtex
from bench.report.methods import Methods, MethodsFacts, methods
from bench.storage.results import ProblemFacts, Results
from bench.study import Entry, Study

MANY_PROBLEMS = 20
"""More problems than these are folded away one by one, below what can be said of all."""


@dataclass(frozen=True)
class Findings:
    """The analysis of a study; every frame has the cells of the study in the study's order."""

    results: Results

    # what was run

    @cached_property
    def pooled(self) -> analysis.Pooled:
        """The trials with the instances of each function pooled; a study without instances stays as it is."""
        names = [entry.label for entry in self.results.study.problems]
        known = {label: self.results.facts(label) for label in names}
        optima = {label: each.optimum for label, each in known.items() if each.optimum is not None}
        features = {label: each.features for label, each in known.items()}
        return analysis.pool_instances(self.results.frame, self.results.traces, names, features, optima)

    @cached_property
    def planned(self) -> dict[str, int]:
        """The trials that a cell should hold, by problem."""
        return {label: self.results.study.trials * len(own) for label, own in self.pooled.members.items()}

    @cached_property
    def study(self) -> Study:
        """The study as it is compared: a function in a dimension is one problem, whatever its instances."""
        entries = {entry.label: entry for entry in self.results.study.problems}
        problems = tuple(entries.get(label) or Entry(label, label) for label in self.pooled.members)
        return replace(self.results.study, problems=problems, trials=max(self.planned.values()))

    @cached_property
    def frame(self) -> pd.DataFrame:
        """The tidy frame with problems and optimizers as categories, and instances pooled."""
        return analysis.in_study_order(self.pooled.frame, self.study)

    @property
    def traces(self) -> analysis.Traces:
        """The traces of its trials."""
        return self.pooled.traces

    @cached_property
    def problems(self) -> list[str]:
        """The labels of the problems that have at least one trial."""
        return [label for label in analysis.labels(self.frame, "problem") if (self.frame["problem"] == label).any()]

    @property
    def many(self) -> bool:
        """Whether there are too many problems to look at each."""
        return len(self.problems) > MANY_PROBLEMS

    @cached_property
    def optimizers(self) -> list[str]:
        """The labels of the study's optimizers."""
        return analysis.labels(self.frame, "optimizer")

    @cached_property
    def coverage(self) -> pd.DataFrame:
        """Stored, failed and missing trials of each cell."""
        return analysis.coverage(self.frame, self.planned)

    @cached_property
    def known(self) -> dict[str, ProblemFacts]:
        """The optimum, bounds and expected values of each problem, as far as they are known."""
        members = self.pooled.members
        return {
            label: self.results.facts(label) if members[label] == [label] else self._function(members[label])
            for label in self.problems
        }

    def _function(self, instances: list[str]) -> ProblemFacts:
        """Return the facts of a function, whose values are precisions."""
        one = self.results.facts(instances[0])
        features = {name: each for name, each in one.features.items() if name != "instance"}
        return replace(one, optimum=0.0, expected={}, features=features)

    @cached_property
    def constrained(self) -> list[str]:
        """The labels of the problems whose constraints were handled."""
        return [label for label, each in self.known.items() if each.constraints]

    @cached_property
    def noisy(self) -> list[str]:
        """The labels of the problems whose values optimizers saw with noise."""
        return [label for label, each in self.known.items() if each.noisy]

    @cached_property
    def mixed(self) -> list[str]:
        """The labels of the problems with integer variables."""
        return [label for label, each in self.known.items() if each.integers]

    @cached_property
    def optima(self) -> dict[str, float]:
        """The best known objective value of the problems that have one."""
        return {label: each.optimum for label, each in self.known.items() if each.optimum is not None}

    @cached_property
    def unbeaten(self) -> dict[str, float]:
        """The known optima that no trial beat by more than rounding; regret is counted from them."""
        lowest = self.summary.groupby("problem")["best"].min()
        found = analysis.reference_values({str(label): best for label, best in lowest.items()}, self.optima)
        return {label: reference.value for label, reference in found.items() if reference.known}

    @cached_property
    def dimensions(self) -> dict[str, int]:
        """The number of search variables of each problem, as far as a trial or the problem shows it."""
        shown = {
            str(label): len(analysis.variables(own)) for label, own in self.frame.groupby("problem", observed=True)
        }
        return {
            label: number
            for label in self.problems
            if (number := shown[label] or self.results.dimension(self.pooled.members[label][0]))
        }

    @cached_property
    def budgets(self) -> dict[str, int]:
        """The evaluations that a trial on each problem was allowed."""
        study = self.results.study
        if isinstance(study.budget, int):
            return dict.fromkeys(self.problems, study.budget)
        own = {label: study.evaluations(dimension) for label, dimension in self.dimensions.items()}
        return {label: own.get(label, max(own.values(), default=1)) for label in self.problems}

    @cached_property
    def allowed(self) -> analysis.Budgets:
        """The evaluations that a trial was allowed: by problem, or by problem and optimizer where budgets differ."""
        own = self.results.budgets
        if all(budget == self.results.study.budget for budget in own.values()):
            return self.budgets
        return {
            (label, optimizer): evaluations(budget, self.dimensions[label])
            if label in self.dimensions
            else self.budgets[label]
            for label in self.problems
            for optimizer, budget in own.items()
        }

    @property
    def scaled(self) -> bool:
        """Whether evaluations are compared by evaluation / dimension, as budgets differ."""
        return len(set(self.budgets.values())) > 1

    @cached_property
    def trials(self) -> tuple[int, int]:
        """The fewest and the most trials of a cell that has any; (0, 0) where no cell has."""
        stored = self.coverage.loc[self.coverage["stored"] > 0, "stored"]
        return (int(stored.min()), int(stored.max())) if len(stored) else (0, 0)

    # at the end of the budget, problem by problem

    @cached_property
    def summary(self) -> pd.DataFrame:
        """The summary of each cell."""
        return analysis.summarise(self.frame)

    @cached_property
    def pairs(self) -> pd.DataFrame:
        """The tests of each pair of optimizers on each problem."""
        return analysis.pairwise_tests(self.frame)

    @cached_property
    def matrix(self) -> pd.DataFrame:
        """The comparison matrix of medians with its letters, one row a cell."""
        letters = analysis.compact_letters(self.summary, self.pairs)
        return analysis.comparison_matrix(self.summary, self.pairs).merge(letters)

    @cached_property
    def ranking(self) -> pd.DataFrame:
        """The number of problems on which each optimizer is ranked first."""
        return analysis.ranking(self.summary, self.pairs)

    # across problems

    @cached_property
    def medians(self) -> pd.DataFrame:
        """The medians of the problems on which every optimizer has a trial, problems by optimizers."""
        return analysis.medians(self.summary)

    @cached_property
    def friedman(self) -> dict[str, Any]:
        """Friedman's test and its Iman-Davenport form."""
        return dict(analysis.friedman(self.medians).iloc[0])

    @cached_property
    def wilcoxon(self) -> pd.DataFrame:
        """Wilcoxon's signed-rank test of each pair of optimizers across problems."""
        return analysis.wilcoxon_tests(self.medians, self.optima)

    # over the evaluations

    @cached_property
    def targets(self) -> pd.DataFrame:
        """The ladder of targets of each problem."""
        return analysis.targets(self.traces, self.optima)

    @cached_property
    def hits(self) -> pd.DataFrame:
        """The evaluations that each trial took to reach each target."""
        return analysis.hitting_times(self.frame, self.traces, self.targets, self.allowed)

    @cached_property
    def success(self) -> pd.DataFrame:
        """The share of trials of each cell that reached a target, with its interval."""
        return analysis.success_rates(self.hits)

    @cached_property
    def running_times(self) -> pd.DataFrame:
        """The ERT of each cell whose instances are pooled to COCO's precisions; without rows where there is none."""
        targets = analysis.precision_targets(self.pooled.functions)
        own = self.frame[self.frame["problem"].isin(self.pooled.functions)]
        table = analysis.expected_running_time(analysis.hitting_times(own, self.traces, targets, self.allowed))
        return table.drop(columns="target").rename(columns={"tau": "precision"})

    @cached_property
    def suite_functions(self) -> list[str]:
        """The labels of the problems that are functions of a suite."""
        return [label for label, each in self.known.items() if "suite" in each.features]

    @cached_property
    def u_scores(self) -> pd.DataFrame:
        """The U-scores of each cell on functions of suites, by trial-based dominance."""
        own = self.frame[self.frame["problem"].isin(self.suite_functions)]
        return analysis.u_scores(own, self.traces, self.unbeaten)

    # time and soundness

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
        return analysis.integrity(
            analysis.in_study_order(results.frame, study),
            study_budget=study.budget if isinstance(study.budget, int) and self.allowed == self.budgets else budgets,
            planned_trials=study.trials,
            traces=results.traces,
            boxes={label: each.continuous for label, each in facts.items() if each.box},
            diagnoses=self.results.checks,
            verifications=self.results.verifications,
            stores=self.results.stores,
        )

    @cached_property
    def methods(self) -> Methods:
        """The methods section of a paper about this run."""
        study, pairs, early = self.study, self.pairs, analysis.stopped_early(self.frame)
        sandboxes = (record.get("sandbox") for record in self.results.environments)
        return methods(
            MethodsFacts(
                study=study,
                trials=self.trials,
                empty=int((self.coverage["stored"] == 0).sum()),
                failed=int(self.coverage["failed"].sum()),
                bibtex=bibtex(study, next(filter(None, sandboxes), None)),
                environments=self.results.environments,
                tests=len(pairs) if pairs["testable"].any() else 0,
                permutation_tests=int((pairs["method"] == "permutation").sum()),
                ranked_problems=len(self.medians),
                scale="".join(self.wilcoxon["scale"].unique()),
                known_optima=int(self.targets.drop_duplicates("problem")["known"].sum()),
                targets=self.targets["problem"].nunique(),
                early={label: int((early & (self.frame["optimizer"] == label)).sum()) for label in self.optimizers},
                centre_bias=self._biased("centre bias"),
                structural_bias=self._biased("structural bias"),
                constrained=len(self.constrained),
                noisy=len(self.noisy),
                mixed=len(self.mixed),
                dominance=self.u_scores["problem"].nunique() if len(self.optimizers) > 1 else 0,
            )
        )

    def _biased(self, check: str) -> dict[str, bool]:
        """Return whether ``bench check`` found a bias in each optimizer that it tested, by label."""
        return {
            label: not each["passed"]
            for label, checks in self.results.checks.items()
            for each in checks
            if each["check"] == check
        }
