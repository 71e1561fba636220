"""How a report names the targets of a study: their unit, the levels that its tables show, and what they mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from bench import analysis
from bench.storage.results import ProblemFacts
from bench.study.targets import Targets, percentages, precisions

FIELD = ("bbob", "cec", "classical")
"""The beginnings of the names of the suites for which the field reports absolute precisions."""

TABLED = 8  # targets of a list that a table shows at most


@dataclass(frozen=True)
class TargetWords:
    """The words for a set of targets.

    Attributes:
        chosen: the targets, as a study holds them.
        kind: a kind's name, "precisions" or "percentages" for a list.
        unit: what a level is, such as "precision". A lower level is harder; that of a running length is d / budget.
        short: the set's name in a table.
        levels: the targets of the success rates, from easy to hard.
        level: the target of data profiles, scaling and spreads.
        tabled: the targets of the tables of running times.
    """

    chosen: Targets
    kind: str
    unit: str
    short: str
    levels: tuple[float, ...]
    level: float
    tabled: tuple[float, ...]

    @property
    def absolute(self) -> bool:
        """Whether targets are precisions, so that an ERT can stand beside a published one."""
        return self.kind in ("precisions", "runlength")

    @property
    def restarts(self) -> bool:
        """Whether shares of targets reached are those of simulated restarts, as the field reports them."""
        return self.kind != "relative"

    def shown(self, level: float) -> str:
        """Return a target as a number in the unit: ``"1e-08"``; of running lengths, the budget over d."""
        return f"{1 / level:g}" if self.kind == "runlength" else f"{level:g}"

    def in_unit(self, table: pd.DataFrame, column: str = "tau") -> pd.DataFrame:
        """Return a table whose column of targets is in the unit, for readers."""
        return table.assign(**{column: 1 / table[column].astype(float)}) if self.kind == "runlength" else table

    def at(self, level: float) -> str:
        """Return a target as text: ``"tau = 0.01"``, ``"precision = 1e-08"``, ``"5% of the optimum"``."""
        if self.kind == "runlength":
            return f"the target for {self.shown(level)} d evaluations"
        if self.kind == "percentages":
            return f"{100 * level:g}% of the optimum"
        if self.kind == "tolerance":
            return f"{level:g} times the tolerance"
        return f"{self.unit} = {level:g}"


def default_targets(facts: Mapping[str, ProblemFacts], functions: list[str]) -> Targets:
    """Return the targets of a study that names none.

    Absolute precisions, where every problem is a function with a known optimum of a suite of the field, or of another
    suite with instances (``functions``); else relative targets: in the units of a design or a recording, 1e-8 means
    nothing.
    """
    usual = [
        problem.optimum is not None and (label in functions or str(problem.features.get("suite", "")).startswith(FIELD))
        for label, problem in facts.items()
    ]
    return "precisions" if usual and all(usual) else "relative"


def target_words(chosen: Targets) -> TargetWords:
    """Return the words for a set of targets."""
    levels: tuple[float, ...]
    tabled: tuple[float, ...]
    if chosen == "relative":
        levels = (1e-1, 1e-2, 1e-3)
        return TargetWords(chosen, "relative", "tau", "relative", levels, 1e-2, levels)
    if chosen == "precisions":
        levels = (1.0, 1e-2, 1e-8)
        return TargetWords(chosen, chosen, "precision", "precisions", levels, 1e-2, analysis.PRECISIONS)
    if chosen == "runlength":
        tabled = tuple(1 / length for length in analysis.RUN_LENGTHS)
        return TargetWords(chosen, chosen, "budget / d", "running lengths", tabled[2:], tabled[3], tabled)
    if chosen == "quantiles":
        levels = (0.5, 0.25, 0.1)
        return TargetWords(chosen, chosen, "quantile", "quantiles", levels, 0.25, (0.75, *levels, 0.05))
    if chosen == "tolerance":
        levels = (2.0, 1.0, 0.5)
        return TargetWords(chosen, chosen, "tolerances", "tolerance", levels, 1.0, (4.0, *levels, 0.25))
    levels_asked = precisions(chosen) or percentages(chosen)
    levels, tabled = _spread(levels_asked, 3), _spread(levels_asked, TABLED)
    middle = levels[len(levels) // 2]
    if percentages(chosen):
        return TargetWords(chosen, "percentages", "share of the optimum", "percentages", levels, middle, tabled)
    return TargetWords(chosen, "precisions", "precision", "these precisions", levels, middle, tabled)


def meaning(words: TargetWords, known: list[bool]) -> str:
    """Return what a target is, for all but relative targets; ``known`` says of each problem if its optimum is known."""
    above = (
        "the known optimum"
        if all(known)
        else "the lowest value that any trial found (every optimum is unknown or beaten)"
        if not any(known)
        else "the known optimum, or the lowest value found where the optimum is unknown or beaten"
    )
    asked = words.chosen if isinstance(words.chosen, list) else []
    if words.kind == "precisions":
        targets = (
            f"{len(asked)} precisions from {asked[0]:g} to {asked[-1]:g}"
            if len(asked) > 1
            else f"the precision {asked[0]:g}"
            if asked
            else "51 precisions from 1e2 to 1e-8, five a decade, as in COCO (Hansen et al. 2021)"
        )
        return f"The targets are {targets}: the best value less {above}."
    if words.kind == "runlength":
        *lengths, last = (f"{length:g}" for length in analysis.RUN_LENGTHS)
        return (
            "The targets of a problem are by running length, as cocopp sets them for expensive functions: for a budget "
            f"of {', '.join(lengths)} and {last} times d evaluations, the next precision (five a decade) after the "
            "hardest that the best of 2009 reached within it in expectation, at least one step harder than that of "
            "the budget before, and 1e-8 at the hardest. So an optimizer as fast as the best algorithm of 2009 on each "
            "function needs slightly more evaluations than the budget, or fewer where 1e-8 is reached within it."
        )
    if words.kind == "percentages":
        return f"The targets are values within {', '.join(map(str, asked))} of {above}; a value of 0 has none."
    if words.kind == "quantiles":
        return (
            "The targets of a problem are quantiles of the best values of all its trials, from 0.95 to 0.05: that of "
            "0.1 is the value that a tenth of all trials reached. They depend on the optimizers compared."
        )
    return (
        "A trial reaches a target when the expected metrics of its best point are within a multiple of their "
        "tolerances, from 8 to 1/8; its time is the evaluation that found this point. Metrics of points on the way are "
        "not recorded."
    )


def _spread(targets: list[float], most: int) -> tuple[float, ...]:
    """Return at most that many of the targets, the first and the last among them."""
    if len(targets) <= most:
        return tuple(targets)
    return tuple(targets[i] for i in np.linspace(0, len(targets) - 1, most).round().astype(int))
