"""The statistics at the end of the budget, on each problem and across problems."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb

import pandas as pd

from bench import analysis
from bench.analysis.across import places, with_winner
from bench.analysis.comparison import chances, order, within_problems
from bench.analysis.error_rates import enough_trials
from bench.analysis.error_rates import levels as levels_of
from bench.analysis.pairwise import adjusted
from bench.analysis.standings import disagreements as disagreements_of
from bench.topics.findings.trials import Trials


@dataclass(frozen=True)
class Final:
    """The values that the trials reached at the end of the budget, or of the largest that all had."""

    trials: Trials
    subject: str = ""  # whose pairs alone are tested

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
        """The tests of each pair of optimizers on each problem."""
        level = self.levels.problems
        pairs = analysis.pairwise_tests(self.trials.frame, level or analysis.ALPHA, self.subject)
        if not level:  # the whole level belongs to the tests over all problems
            pairs = adjusted(pairs, level, self.subject).assign(testable=False)
        return pairs

    @cached_property
    def on_problems(self) -> pd.DataFrame:
        """The pairs with their claims on each problem: p adjusted within it, and which optimizer ends lower."""
        return within_problems(self.pairs)

    @property
    def tested_pairs(self) -> pd.DataFrame:
        """The rows of the pairs that are tested: all, or those of the subject."""
        return self.pairs[self.pairs["p_holm"].notna()]

    @cached_property
    def levels(self) -> analysis.Levels:
        """The levels of the tests on problems and over all of them, which the design of the study gives."""
        sizes = analysis.table(self.summary, "n").apply(lambda sizes_of: sorted(sizes_of, reverse=True)[1:2], axis=1)
        smaller = [int(sizes_of[0]) for label, sizes_of in sizes.items() if sizes_of and label in self.medians.index]
        return levels_of(smaller, self.tested, self.tests)

    @property
    def tested(self) -> int:
        """The number of pairs of optimizers that are tested: all, or those of the subject."""
        optimizers = len(self.trials.optimizers)
        return optimizers - 1 if self.subject else comb(optimizers, 2)

    @property
    def pairs_words(self) -> str:
        """The pairs that are tested, in words."""
        return f"{self.subject} and each other optimizer" if self.subject else "every pair of optimizers"

    @cached_property
    def tests(self) -> int:
        """The number of pairs on problems of which both have trials, and which are tested."""
        there = analysis.table(self.summary, "n") > 0
        if self.subject:
            return int(there.drop(columns=self.subject)[there[self.subject]].to_numpy().sum())
        return sum(comb(int(number), 2) for number in there.sum(axis=1))

    @property
    def enough(self) -> int:
        """The trials a cell from which on complete separation on a problem is significant."""
        return self._enough[0]

    @property
    def level_on_problems(self) -> float:
        """The level of the tests on problems, or with too few trials for any, the one that they have with enough."""
        return self.levels.problems or self._enough[1]

    @cached_property
    def _enough(self) -> tuple[int, float]:
        return enough_trials(len(self.medians), self.tested, self.tests)

    @cached_property
    def standings(self) -> pd.DataFrame:
        """The rank of each cell by its chance to end lower, and the rivals that it is separable from."""
        return analysis.standings(self.summary, self.pairs)

    @cached_property
    def disagreements(self) -> pd.DataFrame:
        """The problems on which median, mean and rank name different optimizers."""
        return disagreements_of(self.summary, self.standings)

    @cached_property
    def ranking(self) -> pd.DataFrame:
        """The place of each optimizer over all problems, and the number of problems on which it is ranked first."""
        table = analysis.ranking(self.summary, self.pairs, standing=self.standings)
        return table.merge(places(self.overall, self.trials.optimizers), on="optimizer")

    # across problems

    @cached_property
    def medians(self) -> pd.DataFrame:
        """The medians of the problems on which every optimizer has a trial, problems by optimizers."""
        return analysis.medians(self.summary)

    @cached_property
    def overall(self) -> pd.DataFrame:
        """The probability of each pair to end lower over all problems, with its tests."""
        tests = analysis.across_problems(self.pairs, self.levels.across, self.subject)
        if self.subject or not len(tests):
            return tests
        return with_winner(tests, self.trials.optimizers, self.levels.across)

    @property
    def tested_overall(self) -> pd.DataFrame:
        """The rows of the pairs over all problems that are tested: all, or those of the subject."""
        return self.overall[self.overall["p_holm"].notna()]

    @cached_property
    def ranked(self) -> list[str]:
        """The labels of the optimizers in the order of every part of a report."""
        return list(self.order["optimizer"])
