"""A study's statistics, computed once for all sections."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from bench import analysis
from bench.results import Results


@dataclass(frozen=True)
class Findings:
    """What the analysis says of a study; every frame knows the study's cells in the study's order."""

    results: Results

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
    def summary(self) -> pd.DataFrame:
        """The summary of each cell."""
        return analysis.summarise(self.frame)

    @cached_property
    def pairs(self) -> pd.DataFrame:
        """The tests of each pair on each problem."""
        return analysis.pairwise_tests(self.frame)

    @cached_property
    def matrix(self) -> analysis.Matrix:
        """The comparison matrix of means."""
        return analysis.comparison_matrix(self.summary, self.pairs)

    @cached_property
    def ranking(self) -> pd.DataFrame:
        """Who is ranked first on how many problems."""
        return analysis.ranking(self.summary, self.pairs)

    @cached_property
    def timing(self) -> pd.DataFrame:
        """What a trial of each optimizer takes."""
        return analysis.timing(self.frame)
