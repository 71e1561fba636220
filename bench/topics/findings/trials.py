"""The trials of a study, its problems and its budgets, as all topics read them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import pandas as pd

from bench import analysis
from bench.analysis.cells import labels as labels_of
from bench.analysis.cells import reference_values, scores
from bench.analysis.own_optimum import ShiftedTraces, Shifts, shifted, shifts
from bench.results.compared import Compared
from bench.results.results import ProblemFacts, StoredResults
from bench.study.descriptions import repairing
from bench.topics.findings.replication import Replication, replications


@dataclass(frozen=True)
class Trials(Compared):
    """The trials of a study, and what is known of its problems and budgets."""

    results: StoredResults

    @property
    def precisions(self) -> list[str]:
        """The problems with pooled instances, whose values are precisions; those of all others are objective values."""
        return self.pooled.functions

    @cached_property
    def replications(self) -> list[Replication]:
        """The trials of the cells, by the number of instances that a problem stands for."""
        return replications(self.coverage, self.pooled.members, self.results.planned)

    @property
    def common(self) -> dict[str, int]:
        """The largest budget of each problem that all optimizers had, where budgets differ; else none."""
        return self.comparable.common

    @property
    def common_words(self) -> str:
        """The words for the common budgets, for the lead: "" where budgets do not differ."""
        if not self.common:
            return ""
        low, high = min(self.common.values()), max(self.common.values())
        if low == high:
            return f"at {low:,} evaluations, the largest budget that all had"
        return f"at the largest budget of each problem that all had ({low:,} to {high:,} evaluations)"

    @cached_property
    def shifts(self) -> Shifts:
        """How much the best value that an optimizer can reach is above the optimum, by problem and optimizer."""
        repaired = {
            label: facts.repaired_optimum
            for label, facts in self.known.items()
            if facts.repaired_optimum is not None and label not in self.pooled.functions
        }
        if not repaired:
            return {}
        confined = [label for label, kept in repairing(self.results.study).items() if kept]
        return shifts(self.whole, self.optima, repaired, confined)

    @cached_property
    def measured(self) -> pd.DataFrame:
        """The trials on problems that work; values count from the optimum that each optimizer can reach."""
        return shifted(self.comparable.working, self.shifts)

    @cached_property
    def measured_final(self) -> pd.DataFrame:
        """The same of the frame whose values are ranked and tested."""
        return shifted(self.frame, self.shifts)

    @cached_property
    def measured_traces(self) -> analysis.Traces:
        """The traces with such values."""
        return ShiftedTraces(self.traces, self.shifts) if self.shifts else self.traces

    @cached_property
    def optimizers(self) -> list[str]:
        """The labels of the study's optimizers."""
        return labels_of(self.whole, "optimizer")

    @cached_property
    def coverage(self) -> pd.DataFrame:
        """Stored, failed and missing trials of each cell."""
        members, planned = self.pooled.members, self.results.planned_on
        cells = product(members, self.optimizers)
        return analysis.coverage(self.whole, {(p, o): planned(o, members[p]) for p, o in cells})

    @cached_property
    def timing(self) -> pd.DataFrame:
        """The evaluations and times of the finished trials of each optimizer."""
        return analysis.timing(self.whole)

    @cached_property
    def feasible(self) -> pd.DataFrame:
        """The share of trials that found a feasible point on the problems with constraints, and when they did."""
        return analysis.feasibility(self.frame, self.traces, self.constrained)

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
        first = self.results.facts(instances[0])
        features = {name: value for name, value in first.features.items() if name != "instance"}
        return replace(first, optimum=0.0, expected={}, features=features)

    @cached_property
    def constrained(self) -> list[str]:
        """The labels of the problems whose constraints were handled."""
        return [label for label, facts in self.known.items() if facts.constraints]

    @cached_property
    def noisy(self) -> list[str]:
        """The labels of the problems whose values optimizers saw with noise."""
        return [label for label, facts in self.known.items() if facts.noisy]

    @cached_property
    def optima(self) -> dict[str, float]:
        """The best known objective value of the problems that have one."""
        return {label: facts.optimum for label, facts in self.known.items() if facts.optimum is not None}

    @property
    def scaled(self) -> bool:
        """Whether evaluations are compared by evaluation / dimension, as budgets differ."""
        return len(set(self.budgets.values())) > 1

    @cached_property
    def unbeaten(self) -> dict[str, float]:
        """The known optima that no trial beat by more than rounding; regret is counted from them."""
        lowest = scores(self.measured).groupby(self.measured["problem"].astype(object)).min()
        references = reference_values({str(label): float(best) for label, best in lowest.items()}, self.optima)
        return {label: reference.value for label, reference in references.items() if reference.known}

    @cached_property
    def suite_functions(self) -> list[str]:
        """The labels of the problems that are functions of a suite."""
        return [label for label, facts in self.known.items() if "suite" in facts.features]
