"""A study's statistics, computed once for all sections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pandas as pd

from bench import analysis
from bench.errors import BenchError
from bench.problem import Problem
from bench.report.methods import Methods, MethodsFacts, methods
from bench.results import Results
from bench.study import Study


@dataclass(frozen=True)
class Findings:
    """What the analysis says of a study; every frame knows the study's cells in the study's order."""

    results: Results

    # what was run

    @cached_property
    def frame(self) -> pd.DataFrame:
        """The tidy frame, problems and optimizers as categories."""
        return analysis.in_study_order(self.results.frame, self.results.study)

    @cached_property
    def problems(self) -> list[str]:
        """The labels of the problems that have at least one trial."""
        return [label for label in analysis.labels(self.frame, "problem") if (self.frame["problem"] == label).any()]

    @cached_property
    def optimizers(self) -> list[str]:
        """The labels of the study's optimizers."""
        return analysis.labels(self.frame, "optimizer")

    @cached_property
    def coverage(self) -> pd.DataFrame:
        """Stored, failed and missing trials of each cell."""
        return analysis.coverage(self.frame, self.results.study.trials)

    @cached_property
    def _loaded(self) -> tuple[dict[str, Problem], dict[str, str]]:
        problems, reasons = {}, {}
        for label in self.problems:
            try:
                problems[label] = self.results.problem(label)
            except BenchError as error:
                reasons[label] = str(error)
            except Exception as error:  # a plug-in may raise anything
                reasons[label] = f"{type(error).__name__}: {error}"
        return problems, reasons

    @property
    def loaded(self) -> dict[str, Problem]:
        """The problems that can be loaded here, by label."""
        return self._loaded[0]

    @property
    def unloaded(self) -> dict[str, str]:
        """Why each other problem cannot be: its optimum, box and expected figures are then not known."""
        return self._loaded[1]

    @cached_property
    def optima(self) -> dict[str, float]:
        """The best known objective value of the problems that have one."""
        return {label: each.optimum for label, each in self.loaded.items() if each.optimum is not None}

    @property
    def expected(self) -> dict[str, Mapping[str, tuple[float, float]]]:
        """The true value and tolerance of domain figures, by problem."""
        return {label: each.expected for label, each in self.loaded.items()}

    @property
    def boxes(self) -> dict[str, dict[str, tuple[float, float]]]:
        """The bounds of each search variable, by problem."""
        return {
            label: dict(zip(each.variables, zip(each.lower.tolist(), each.upper.tolist(), strict=True), strict=True))
            for label, each in self.loaded.items()
        }

    # at the end of the budget, problem by problem

    @cached_property
    def summary(self) -> pd.DataFrame:
        """The summary of each cell."""
        return analysis.summarise(self.frame)

    @cached_property
    def pairs(self) -> pd.DataFrame:
        """The tests of each pair on each problem."""
        return analysis.pairwise_tests(self.frame)

    @cached_property
    def matrix(self) -> pd.DataFrame:
        """The comparison matrix of medians, one row a cell."""
        return analysis.comparison_matrix(self.summary, self.pairs)

    @cached_property
    def ranking(self) -> pd.DataFrame:
        """Who is ranked first on how many problems."""
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

    @cached_property
    def improvement(self) -> pd.DataFrame:
        """The probability of improvement of each pair over all problems."""
        return analysis.probability_of_improvement(self.frame)

    @cached_property
    def aggregate(self) -> pd.DataFrame:
        """The interquartile mean of the normalised errors of each optimizer."""
        return analysis.interquartile_mean(self.frame, self.optima)

    # over the evaluations

    @cached_property
    def curves(self) -> pd.DataFrame:
        """The median best-so-far value and its quartiles."""
        grid = analysis.evaluation_grid(self.results.study.budget)
        return analysis.convergence(self.frame, self.results.traces, grid)

    @cached_property
    def targets(self) -> pd.DataFrame:
        """The ladder of targets of each problem."""
        return analysis.targets(self.results.traces, self.optima)

    @cached_property
    def dimensions(self) -> dict[str, int]:
        """The number of search variables of each problem, as its trials hold them."""
        known = self.frame.filter(regex="^x_").notna().groupby(self.frame["problem"], observed=True).any()
        return {str(problem): int(number) for problem, number in known.sum(axis=1).items()}

    @cached_property
    def hits(self) -> pd.DataFrame:
        """The evaluations each trial took to reach each target."""
        return analysis.hitting_times(self.frame, self.results.traces, self.targets, self.results.study.budget)

    # time and soundness

    @cached_property
    def timing(self) -> pd.DataFrame:
        """What a trial of each optimizer takes."""
        return analysis.timing(self.frame)

    @cached_property
    def integrity(self) -> pd.DataFrame:
        """The checks of the results themselves."""
        return analysis.integrity(
            self.frame,
            study_budget=self.results.study.budget,
            planned_trials=self.results.study.trials,
            traces=self.results.traces,
            boxes=self.boxes,
            diagnoses=self.results.checks,
        )

    @cached_property
    def methods(self) -> Methods:
        """The methods section of a paper about this run."""
        study, pairs = self.results.study, self.pairs
        stored = self.coverage["stored"]
        return methods(
            MethodsFacts(
                study=study,
                trials=(int(stored.min()), int(stored.max())),
                failed=int(self.coverage["failed"].sum()),
                bibtex={entry.label: _bibtex(study, entry.label) for entry in study.optimizers},
                environments=self.results.environments,
                tests=len(pairs),
                permutation_tests=int((pairs["method"] == "permutation").sum()),
                ranked_problems=len(self.medians),
                scale="".join(self.wilcoxon["scale"].unique()),
                known_optima=len(self.optima),
                targets=self.targets["problem"].nunique(),
                early=self._early,
                centre_bias={
                    label: not each["passed"]
                    for label, those in self.results.checks.items()
                    for each in those
                    if each["check"] == "centre bias"
                },
            )
        )

    @property
    def _early(self) -> dict[str, int]:
        """How many trials of each optimizer stopped by a criterion of their own."""
        own = self.frame["stop"].notna() & ~self.frame["stop"].isin(("budget", "undeclared"))
        return {label: int((own & (self.frame["optimizer"] == label)).sum()) for label in self.optimizers}


def _bibtex(study: Study, label: str) -> str:
    """Return what an optimizer asks to be cited by, "" where its plug-in is missing here."""
    try:
        return study.optimizer(label).bibtex
    except BenchError:
        return ""
