"""What was run: the trials of a study, its problems and its budgets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import pandas as pd

from bench import analysis
from bench.budget import evaluations
from bench.report.problem_words import sweeps
from bench.report.replication import Replication, replications
from bench.rope import Rope
from bench.storage.results import ProblemFacts, Results
from bench.study import Entry, Study
from bench.targets import Targets

MANY_PROBLEMS = 20
"""More problems than these are folded away one by one, below what can be said of all."""


@dataclass(frozen=True)
class Trials:
    """The trials of a study; every frame has the cells of the study in the study's order."""

    results: Results
    asked: Targets | None = None  # targets other than the study's own
    asked_rope: Rope | None = None  # likewise
    beside_best: bool = False  # whether the best of 2009 stands beside the optimizers

    @cached_property
    def pooled(self) -> analysis.Pooled:
        """The trials with the instances of each function pooled; a study without instances stays as it is."""
        names = [entry.label for entry in self.results.study.problems]
        known = {label: self.results.facts(label) for label in names}
        optima = {label: each.optimum for label, each in known.items() if each.optimum is not None}
        features = {label: each.features for label, each in known.items()}
        return analysis.pool_instances(self.results.frame, self.results.traces, names, features, optima)

    @property
    def precisions(self) -> list[str]:
        """The problems with pooled instances, whose values are precisions; those of all others are objective values."""
        return self.pooled.functions

    @cached_property
    def replications(self) -> list[Replication]:
        """The trials of the cells, by the number of instances that a problem stands for."""
        return replications(self.coverage, self.pooled.members, self.results.planned)

    @cached_property
    def decisions(self) -> analysis.Decisions:
        """The outcome of the study's declared looks at its trials; nothing is decided without looks."""
        return analysis.decide(self.frame, self.results.study.looks)

    @property
    def extensions(self) -> list[tuple[int, int]]:
        """The trials of each cell that were complete, and those then asked for, of every run that asked for more."""
        keys = [(each.get("extends"), each.get("trials")) for each in self.results.environments]
        found = [(held, asked) for held, asked in keys if isinstance(held, int) and isinstance(asked, int)]
        return [] if self.results.study.looks else list(dict.fromkeys(found))

    @cached_property
    def study(self) -> Study:
        """The study as it is compared: a function in a dimension is one problem, whose trials are by instance."""
        entries = {entry.label: entry for entry in self.results.study.problems}
        problems = tuple(entries.get(label) or Entry(label, label) for label in self.pooled.members)
        return replace(self.results.study, problems=problems)

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
        members, planned = self.pooled.members, self.results.planned
        cells, stopped = product(members, self.optimizers), self.decisions.stopped
        return analysis.coverage(
            self.frame, {(p, o): stopped.get((p, o), planned[o] * len(members[p])) for p, o in cells}
        )

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

    @cached_property
    def blocks(self) -> dict[str, str]:
        """The block of each problem: problems of one sweep, and one function in several dimensions, are one block."""
        found = {}
        for label, each in self.known.items():
            features = each.features
            function = f"{features['suite']} {features['function']}" if {"suite", "function"} <= set(features) else ""
            found[label] = str(features.get("sweep") or function or label)
        return found

    @cached_property
    def sweeps(self) -> dict[str, list[str]]:
        """The problems, three or more, that are steps of one sweep, by its name."""
        return sweeps(self.known)
