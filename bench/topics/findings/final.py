"""The statistics at the end of the budget, on each problem and across problems."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from bench import analysis
from bench.analysis.comparison import chances, order
from bench.topics.findings.trials import Trials

FIRST, CROWD = 10, 60
"""Of more optimizers than the other, only pairs of the first ones have rows, as all would fill memory and disk."""


@dataclass(frozen=True)
class Final:
    """The values that the trials reached at the end of the budget, or of the largest that all had."""

    trials: Trials
    subject: str = ""  # whose pairs alone are tested
    about: str = ""  # the optimizer that the page is about, named late or not

    @cached_property
    def chances(self) -> pd.DataFrame:
        """The chance of each optimizer to end lower than its rivals on each problem, and its rank by that."""
        return chances(self.trials.frame)

    @cached_property
    def order(self) -> pd.DataFrame:
        """The optimizers in the order of their chance over problems, which is that of every part of a report."""
        return order(self.chances)

    # problem by problem

    @cached_property
    def summary(self) -> pd.DataFrame:
        """The summary of each cell."""
        return analysis.summarise(self.trials.frame)

    @cached_property
    def measured_summary(self) -> pd.DataFrame:
        """The summary of each cell with values that count from the optimum that each optimizer can reach."""
        return analysis.summarise(self.trials.measured_final) if self.trials.shifts else self.summary

    @cached_property
    def pairs(self) -> pd.DataFrame:
        """The tests of the pairs on each problem; of many optimizers, those of the first ones with each other one."""
        kept = {*self.ranked[:FIRST], self.about} if len(self.ranked) > CROWD else None
        return analysis.pairwise_tests(self.trials.frame, subject=self.subject, kept=kept)

    @property
    def pairs_words(self) -> str:
        """The pairs that are tested, in words."""
        return f"{self.subject} and each other optimizer" if self.subject else "every pair of optimizers"

    # across problems

    @cached_property
    def medians(self) -> pd.DataFrame:
        """The medians of the problems on which every optimizer has a trial, problems by optimizers."""
        return analysis.medians(self.summary)

    @cached_property
    def ranked(self) -> list[str]:
        """The labels of the optimizers in the order of every part of a report."""
        return list(self.order["optimizer"])
