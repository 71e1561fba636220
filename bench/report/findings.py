"""Compute the statistics of a study once for all sections of its report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, cast

import numpy as np
import pandas as pd

from bench import analysis
from bench.analysis.equivalence import differences
from bench.analysis.factors import Contributions, contributions
from bench.analysis.integrity import undeclared
from bench.budget import described, evaluations
from bench.errors import BenchError
from bench.execution.descriptions import Description, describe
from bench.importing.best2009 import best2009, function_of
from bench.plots import style
from bench.report.landscapes import Landscapes, landscapes
from bench.report.methods import Methods, MethodsFacts, methods
from bench.report.target_words import TargetWords, default_targets, target_words
from bench.rope import Rope
from bench.storage.results import ProblemFacts, Results
from bench.study import Entry, Study
from bench.targets import NO_METRIC, Targets

MANY_OPTIMIZERS = 10
"""Of more optimizers than these only the best are drawn in colour, and pairs are shown as a matrix."""

COLOURED = 8  # optimizers, as many as there are colours
CROWD = 60
"""Of more optimizers than these only the best are shown problem by problem; the files of the whole study have all."""

MANY_PROBLEMS = 20
"""More problems than these are folded away one by one, below what can be said of all."""


@dataclass(frozen=True)
class Findings:
    """The analysis of a study; every frame has the cells of the study in the study's order."""

    results: Results
    asked: Targets | None = None  # targets other than the study's own
    asked_rope: Rope | None = None  # likewise
    beside_best: bool = False  # whether the best of 2009 stands beside the optimizers

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
        """The trials that a cell should hold at most, by problem."""
        return {label: self.results.study.trials * len(own) for label, own in self.pooled.members.items()}

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
    def ranked(self) -> list[str]:
        """The labels of the optimizers by mean rank, those without one last."""
        ranks = self.ranking.set_index("optimizer")["mean_rank"]
        return list(ranks.sort_values(kind="stable", na_position="last").index)

    @cached_property
    def looks(self) -> style.Looks:
        """The look of each optimizer in every figure: of many, only the best have one of their own."""
        best = self.ranked[:COLOURED] if len(self.optimizers) > MANY_OPTIMIZERS else None
        return style.looks(self.optimizers, best)

    @property
    def crowd(self) -> bool:
        """Whether there are too many optimizers to show all of them problem by problem."""
        return len(self.optimizers) > CROWD

    @cached_property
    def drawn(self) -> style.Looks:
        """The looks of those whose curves are drawn problem by problem: of a crowd, the best."""
        return {label: look for label, look in self.looks.items() if not (self.crowd and look.background)}

    @property
    def drawn_words(self) -> tuple[str, ...]:
        """The sentence that says that not all are drawn, where that is so."""
        drawn, every = len(self.drawn), len(self.optimizers)
        return (f"Drawn are the {drawn} best of {every} optimizers by mean rank.",) if drawn < every else ()

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

    @cached_property
    def sweeps(self) -> dict[str, list[str]]:
        """The problems, three or more, that are steps of one sweep, by its name."""
        found: dict[str, list[str]] = {}
        for label, each in self.known.items():
            if name := str(each.features.get("sweep", "")):
                found.setdefault(name, []).append(label)
        return {name: own for name, own in found.items() if len(own) > 2}

    # at the end of the budget, problem by problem

    @cached_property
    def summary(self) -> pd.DataFrame:
        """The summary of each cell."""
        return analysis.summarise(self.frame)

    @cached_property
    def pairs(self) -> pd.DataFrame:
        """The tests of each pair of optimizers on each problem, those of the looks where the study declares any."""
        pairs = analysis.pairwise_tests(self.frame)
        return analysis.at_looks(pairs, self.decisions) if self.results.study.looks else pairs

    @property
    def written_pairs(self) -> pd.DataFrame:
        """The tests that a report writes as a file: of a crowd, those among the best, as all would fill a disk."""
        if not self.crowd:
            return self.pairs
        best = self.ranked[:CROWD]
        return self.pairs[self.pairs["first"].isin(best) & self.pairs["second"].isin(best)]

    @cached_property
    def matrix(self) -> pd.DataFrame:
        """The comparison matrix of medians with its letters, one row a cell."""
        letters = analysis.compact_letters(self.summary, self.pairs, standing=self.standings)
        return analysis.comparison_matrix(self.summary, self.pairs, standing=self.standings).merge(letters)

    @cached_property
    def standings(self) -> pd.DataFrame:
        """The rank of each cell by the rivals that it beats, and those that it is separable from."""
        return analysis.standings(self.summary, self.pairs)

    @cached_property
    def disagreements(self) -> pd.DataFrame:
        """The problems on which median, mean and rank name different optimizers."""
        return analysis.disagreements(self.summary, self.standings)

    @cached_property
    def ranking(self) -> pd.DataFrame:
        """The number of problems on which each optimizer is ranked first."""
        return analysis.ranking(self.summary, self.pairs, standing=self.standings)

    @cached_property
    def testable(self) -> bool:
        """Whether any test of a pair can be significant with the trials there are."""
        return bool(self.pairs["testable"].any())

    # across problems

    @cached_property
    def certainty(self) -> pd.DataFrame:
        """How far other trials on the same problems could move the ranking."""
        return analysis.ranking_certainty(self.frame)

    @cached_property
    def stability(self) -> pd.DataFrame:
        """The mean rank of each optimizer over the number of trials that count."""
        return analysis.rank_stability(self.frame)

    @cached_property
    def needed(self) -> pd.DataFrame:
        """The trials that would separate the pairs that are not separated, with a power of 80 %."""
        return self.needed_for(analysis.POWER)

    def needed_for(self, power: float) -> pd.DataFrame:
        """Return the trials that would separate the pairs that are not separated, with a power."""
        return analysis.trials_needed(
            self.frame, self.pairs, self.standings, power=power, looks=self.results.study.looks
        )

    @cached_property
    def improvement(self) -> pd.DataFrame:
        """The probability that a trial of one optimizer ends below one of another, over all problems."""
        return analysis.probability_of_improvement(self.frame)

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

    @property
    def rope(self) -> Rope | None:
        """The differences of medians that count as equal, where any are given."""
        return self.asked_rope or self.results.study.rope

    @cached_property
    def equivalence(self) -> pd.DataFrame:
        """The differences of each pair on each problem beside the rope; none without a rope."""
        return differences(self.frame, self.rope) if self.rope else pd.DataFrame()

    @cached_property
    def contributions(self) -> dict[str, Contributions]:
        """What the parameters of each sweep contribute, by its name; a sweep that lacks a combination has no entry."""
        return {each.name: contributions(self.frame, each) for each in self.study.sweeps if not each.missing}

    # over the evaluations

    @cached_property
    def stages(self) -> pd.DataFrame:
        """The rank of each cell after some shares of the budget."""
        return analysis.stage_ranks(self.frame, self.traces, self.budgets)

    @cached_property
    def unused(self) -> pd.DataFrame:
        """The share of the budget that each optimizer left."""
        return analysis.unused_budget(self.frame, self.allowed)

    @cached_property
    def words(self) -> TargetWords:
        """The words for the targets: those asked for, the study's own, or the usual ones of its problems."""
        usual = default_targets(self.known, self.pooled.functions)
        return target_words(self.asked or self.results.study.targets or usual)

    def check_targets(self) -> None:
        """Raise BenchError where no problem has what the targets, or the best of 2009, are measured by."""
        if self.words.kind == "tolerance" and not any(each.expected for each in self.known.values()):
            raise BenchError(NO_METRIC)
        if self.beside_best and self.words.kind != "precisions":
            raise BenchError(
                f"the running times of best2009 are those to precisions, and the targets are {self.words.kind}; add "
                "--targets precisions or leave out best2009"
            )
        _ = self.best_times  # where there are none, a sentence says so

    @cached_property
    def targets(self) -> pd.DataFrame:
        """The targets of each problem."""
        return self._targets(self.words)

    @cached_property
    def hits(self) -> pd.DataFrame:
        """The evaluations that each trial took to reach each target."""
        return self._hits(self.words)

    def _targets(self, words: TargetWords) -> pd.DataFrame:
        table = analysis.target_table(words.chosen, self.frame, self.traces, self.optima)
        if words.kind != "tolerance":
            return table
        return table[table["problem"].isin([label for label, each in self.known.items() if each.expected])]

    def _hits(self, words: TargetWords) -> pd.DataFrame:
        if words.kind == "tolerance":
            expected = {label: each.expected for label, each in self.known.items()}
            return analysis.tolerance_times(self.frame, self.traces, expected, self.allowed)
        targets = self.targets if words == self.words else self._targets(words)
        return analysis.hitting_times(self.frame, self.traces, targets, self.allowed)

    @cached_property
    def success(self) -> pd.DataFrame:
        """The share of trials of each cell that reached a target, with its interval."""
        return analysis.success_rates(self.hits, self.words.levels)

    @cached_property
    def running_times(self) -> pd.DataFrame:
        """The ERT of each cell to the targets of the tables, with its spread, also by dimension and in seconds.

        The targets have the name of their unit; times in seconds end with ``_s``.
        """
        hits = self.hits
        codes, taus = pd.factorize(hits["tau"].to_numpy(dtype=float))
        tabled = np.isclose(taus[:, np.newaxis], self.words.tabled, rtol=1e-9, atol=0)
        kept = tabled.any(axis=1)[codes]
        rounded = np.array(self.words.tabled)[tabled.argmax(axis=1)]  # without the rounding of a ladder
        own = hits[kept].assign(tau=rounded[codes[kept]])
        table = analysis.running_times(own)
        times = analysis.running_times(analysis.in_seconds(own, self.frame))
        names = ["ert", "low", "high", "p10", "p90"]
        seconds = times[names].add_suffix("_s") if len(times) else pd.DataFrame(columns=[f"{each}_s" for each in names])
        dimension = table["problem"].astype(object).map(self.dimensions).astype(float)
        table = table.assign(ert_per_d=table["ert"].astype(float) / dimension)
        if self.beside_best:
            best = self.best_times.set_index(["problem", "precision"])["ert"]
            keys = pd.MultiIndex.from_arrays([table["problem"].astype(object), table["tau"].astype(float)])
            table = table.assign(best2009=best.reindex(keys).to_numpy())
        return pd.concat([table, seconds], axis=1).drop(columns="target").rename(columns={"tau": self.words.unit})

    @cached_property
    def best_times(self) -> pd.DataFrame:
        """The ERT of the best of 2009 to the targets of the tables: problem, precision and ert.

        It is missing on functions without any, and where trials beat the optimum that precisions are measured from.
        """
        if not self.beside_best:
            return pd.DataFrame(columns=["problem", "precision", "ert"])
        names = {entry.label: entry.name for entry in self.results.study.problems}
        functions = {label: function_of(names[self.pooled.members[label][0]]) for label in self.problems}
        known = best2009(functions.values())
        levels = sorted({*self.words.tabled, *self.words.levels}, reverse=True)
        kept = {label: name for label, name in functions.items() if label in self.unbeaten}
        return analysis.reference_times(known, kept, levels)

    @cached_property
    def restart_shares(self) -> pd.DataFrame:
        """The shares of simulated restarts over all targets of each cell, over evaluations up to ten times the budget.

        Over evaluations / d where budgets differ.
        """
        return self.restarts_per_dimension if self.scaled else self._restart_shares(self.budgets)

    @cached_property
    def restarts_per_dimension(self) -> pd.DataFrame:
        """The same over evaluations / d, of the problems whose dimension is known."""
        most = {label: self.budgets[label] / d for label, d in self.dimensions.items()}
        return self._restart_shares(most, self.dimensions)

    def _restart_shares(self, most: Mapping[str, float], dimensions: dict[str, int] | None = None) -> pd.DataFrame:
        budget, hits = max(most.values(), default=1.0), self.hits
        first = 1 / max(dimensions.values(), default=1) if dimensions else 1.0
        grid = np.append(np.geomspace(first, budget, 50), np.geomspace(budget, 10 * budget, 11)[1:])
        own = hits if dimensions is None else hits[hits["problem"].isin(dimensions)]
        return analysis.restart_shares(own, grid, dimensions)

    @cached_property
    def target_sets(self) -> pd.DataFrame:
        """The mean area under the runtime ECDF, and the rank, of each optimizer under three sets of targets."""
        others = [kind for kind in ("precisions", "relative", "quantiles") if kind != self.words.chosen][:2]
        areas = {self.words.short: analysis.target_areas(self.hits, self.budgets)}
        for each in map(target_words, others):
            targets = dict(list(self._targets(each).groupby("problem", observed=True)))
            # Problem by problem: the hits of all trials on all targets may take a gigabyte.
            tables = [
                analysis.target_areas(
                    analysis.hitting_times(own, self.traces, targets[label], self.allowed), self.budgets
                )
                for label, own in self.frame.groupby("problem", observed=True)
                if label in targets
            ]
            areas[each.short] = pd.concat(tables, ignore_index=True) if tables else areas[self.words.short].head(0)
        return analysis.compare_sets(areas, self.optimizers)

    @cached_property
    def aocc(self) -> pd.DataFrame:
        """The area over the convergence curve of each cell on problems whose optimum is known and not beaten."""
        return analysis.aocc(self.frame, self.traces, self.unbeaten, self.budgets)

    @cached_property
    def suite_functions(self) -> list[str]:
        """The labels of the problems that are functions of a suite."""
        return [label for label, each in self.known.items() if "suite" in each.features]

    @cached_property
    def u_scores(self) -> pd.DataFrame:
        """The U-scores of each cell on functions of suites, by trial-based dominance."""
        own = self.frame[self.frame["problem"].isin(self.suite_functions)]
        return analysis.u_scores(own, self.traces, self.unbeaten)

    @cached_property
    def landscapes(self) -> Landscapes:
        """The features of the problems' landscapes."""
        return landscapes(self.results, {label: self.pooled.members[label][0] for label in self.problems})

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
        """The optimizers as their plug-ins describe them here, by label."""
        sandboxes = (record.get("sandbox") for record in self.results.environments)
        return describe(self.study, next(filter(None, sandboxes), None))

    @cached_property
    def methods(self) -> Methods:
        """The methods section of a paper about this run."""
        study, pairs, early = self.study, self.pairs, analysis.stopped_early(self.frame)
        return methods(
            MethodsFacts(
                study=study,
                trials=self.trials,
                empty=int((self.coverage["stored"] == 0).sum()),
                failed=int(self.coverage["failed"].sum()),
                bibtex={label: each.bibtex for label, each in self.descriptions.items()},
                environments=self.results.environments,
                tests=len(pairs) if self.testable else 0,
                permutation_tests=int((pairs["method"] == "permutation").sum()),
                ranked_problems=len(self.medians),
                scale="".join(self.wilcoxon["scale"].unique()),
                known_optima=int(self.targets.drop_duplicates("problem")["known"].sum()),
                targets=self.targets["problem"].nunique(),
                target_set=self.words,
                aocc=self.aocc["problem"].nunique() if self.words.kind == "precisions" else 0,
                early={label: int((early & (self.frame["optimizer"] == label)).sum()) for label in self.optimizers},
                centre_bias=self._biased("centre bias"),
                structural_bias=self._biased("structural bias"),
                constrained=len(self.constrained),
                noisy=len(self.noisy),
                mixed=len(self.mixed),
                rope=self.rope if len(self.equivalence) else None,
                landscapes=len(self.landscapes.table),
                dominance=self.u_scores["problem"].nunique() if len(self.optimizers) > 1 else 0,
                budgets={label: described(each) for label, each in self.results.budgets.items()},
                planned=min(self.results.planned.values()) > 0,
                best2009=self.best_times.dropna()["problem"].nunique(),
                tuning=self.study.tuning,
                sweeps=sum(not each.levels.empty for each in self.contributions.values()),
                stopped=len(self.decisions.stopped),
                extensions=undeclared(self.extensions),
                needed="" if self.needed.empty else str(self.needed["method"].iloc[0]),
                stability=len(self.stability) > 0,
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
