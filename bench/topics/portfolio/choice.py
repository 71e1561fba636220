"""Choose optimizers as a portfolio: scores at a budget, features of the problems, and the advice."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from bench.analysis.portfolio import target_shares
from bench.analysis.selection import LEAST_FUNCTIONS, NEIGHBOURS, selection_gain, validated_selection
from bench.report.wording import count
from bench.study.budget import Budget
from bench.topics.findings import Findings
from bench.topics.landscapes.features import landscapes, sample


@dataclass(frozen=True)
class Choice:
    """The optimizers of a study to choose from, at one budget.

    Attributes:
        findings: the study's.
        asked: the budget at which its trials are looked at; by default their own.
    """

    findings: Findings
    asked: Budget | None = None

    @cached_property
    def budgets(self) -> dict[str, int]:
        """The evaluations that count, by problem; a problem whose trials had fewer than asked for is left out."""
        trials = self.findings.trials
        spent = {problem: trials.common.get(problem, trials.budgets[problem]) for problem in trials.problems}
        if self.asked is None:
            return spent
        wanted = {
            problem: self.asked.evaluations(trials.dimensions.get(problem, 1))
            for problem in spent
            if problem in trials.dimensions or self.asked.number
        }
        return {problem: most for problem, most in wanted.items() if most <= spent[problem]}

    @property
    def blocks(self) -> dict[str, str]:
        """The function of each problem: all its dimensions, or the sweep that the problem is a step of."""
        return self.findings.trials.blocks

    @cached_property
    def scores(self) -> pd.DataFrame:
        """The score of each trial."""
        return target_shares(self.findings.anytime.hits, self.budgets)

    @cached_property
    def charged(self) -> pd.DataFrame:
        """The score of each trial where the sample that describes the problem comes before it."""
        dimensions = self.findings.trials.dimensions
        cost = {problem: sample(dimensions.get(problem, 0)) for problem in self.budgets}
        return target_shares(self.findings.anytime.hits, self.budgets, cost)

    @cached_property
    def features(self) -> pd.DataFrame:
        """The features of the problems that could be described, the dimension among them."""
        table = self.findings.of(landscapes).table
        table = table[table.index.isin(list(self.budgets))]
        return table.assign(dimension=[self.findings.trials.dimensions.get(problem, np.nan) for problem in table.index])

    @cached_property
    def validated(self) -> pd.DataFrame:
        """The optimizers that features would have chosen, functions left out."""
        return validated_selection(self.features, self.scores, self.charged, self.blocks)

    @cached_property
    def gain(self) -> tuple[float, float, float]:
        """The gain of the choice by features over the single best, with its interval."""
        return selection_gain(self.validated)

    @property
    def pays(self) -> bool:
        """Whether the choice by features is shown to be better than the single best."""
        return bool(self.gain[1] > 0)


def points(difference: float, low: float, high: float) -> str:
    """Return a difference of shares in points of a percentage with its interval: "3.1 (95% interval 1.0 to 5.2)"."""
    shown, lowest, highest = (f"{round(100 * share, 1) + 0.0:.1f}" for share in (difference, low, high))  # no "-0.0"
    if np.isnan(low):
        return f"{shown} (no interval, as this is one function)"
    return f"{shown} (95% interval {lowest} to {highest})"


def gap_sentence(gap: pd.DataFrame) -> str:
    """Return whether the virtual best is shown to be above the single best, from the gap of a portfolio."""
    row = gap.iloc[0]
    by = points(*(float(row[name]) for name in ("gap", "low", "high")))
    over = f"percentage points over {count(int(row['functions']), 'function')}"
    beginning = (
        "Which optimizer is best depends on the problem"
        if row["shown"]
        else "These data show no gap between the virtual best and the single best"
    )
    return (
        f"{beginning}: the virtual best reaches {row['virtual_score']:.1%} of the targets and the single best, "
        f"{row['single']} on all trials, {row['single_score']:.1%}, a difference of {by} {over}."
    )


def selection_sentence(choice: Choice) -> str:
    """Return whether the choice by features is shown to be better than the single best, or why that is not known."""
    validated = choice.validated
    if validated.empty:
        functions = len({choice.blocks.get(problem, problem) for problem in choice.features.index})
        return (
            f"Whether to choose by features of the landscape is validated from {LEAST_FUNCTIONS} functions on; here "
            f"{functions} can be described."
        )
    chosen, single = (validated.groupby("function")[name].mean().mean() for name in ("score", "single_score"))
    outcome = "pays" if choice.pays else "is not shown to be better than the single best"
    return (
        f"To choose by features of the landscape {outcome}: with each of {validated['function'].nunique()} functions "
        f"left out in turn, the best optimizer on the {NEIGHBOURS} problems with the most similar features reaches "
        f"{chosen:.1%} of the targets, after the sample that shows the features, and the single best, chosen on all "
        f"trials, {single:.1%}, a difference of {points(*choice.gain)} percentage points."
    )
