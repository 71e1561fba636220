"""Foresee from a study's design alone which difference its trials can show, and how many a difference needs."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import comb, isnan

from bench import analysis
from bench.analysis.direction import ALPHA, least_p
from bench.analysis.power import POWER, detectable_across, power_at
from bench.contract.families import function_of
from bench.report.wording import count
from bench.study import Study

GAP = 0.71  # an A12 that Vargha and Delaney (2000) call large
MOST = 500  # trials a cell; a difference that needs more is practically not found


@dataclass(frozen=True)
class Design:
    """How many problems are tested, how many pairs on each, at which level of each test over all, with which power."""

    problems: int
    pairs: int
    across: float
    power: float

    def shown(self, trials: int) -> tuple[float, float]:
        """Return the smallest A12 that the test on a problem finds, and that over all; NaN where none can be found."""
        return (
            analysis.detectable_a12(trials, self.single, self.power),
            detectable_across(trials, self.problems, self.across, self.power),
        )

    def shows_on_a_problem(self, gap: float, trials: int) -> bool:
        """Return whether the test on a problem finds an A12 with so many trials."""
        return self._can_reject(trials, self.single) and power_at(gap, trials, self.single) >= self.power

    def shows_over_all(self, gap: float, trials: int) -> bool:
        """Return the same of the test over all problems, on each of which A12 is the same."""
        can = self._can_reject(trials * self.problems, self.across)
        return can and power_at(gap, trials, self.across, self.problems) >= self.power

    @property
    def places(self) -> list[str]:
        """Where its tests are made: over all problems only with several."""
        return ["on a problem", "over all problems"][: min(self.problems, 2)]

    @property
    def single(self) -> float:
        """The level of the first of the tests on a problem, by Holm's method."""
        return ALPHA / self.pairs

    def _can_reject(self, trials: int, level: float) -> bool:
        return bool(least_p(trials) <= level)


def foreseen(study: Study, gap: float = GAP, power: float = POWER) -> list[str]:
    """Return sentences on the smallest A12 that the study's tests find, and on the trials that find a ``gap``.

    Two normal samples of one spread are assumed. The instances of a function count as trials of one problem.
    """
    design, trials, instances = _design(study, power)
    k = len(study.optimizers)
    words = (
        f"{count(k, 'optimizer')}, {count(design.problems, 'problem')}, {count(trials, 'trial')} of each on a problem"
    )
    words += f" ({study.trials:,} on each of {instances:,} instances)" if instances > 1 else ""
    words += f", {study.subject} against each other one" if study.subject else ""
    finds = (design.shows_on_a_problem, design.shows_over_all)
    needed = [f"{place} {_needed(partial(shows, gap))}" for place, shows in zip(design.places, finds, strict=False)]
    return [
        f"The design: {words}.",
        smallest(study, power),
        f"Trials of each on a problem that an A12 of {gap:g} needs: {', '.join(needed)}.",
    ]


def smallest(study: Study, power: float = POWER) -> str:
    """Return the sentence on the smallest A12 that the study's tests find."""
    design, trials, _ = _design(study, power)
    found = [
        f"{place} {'none' if isnan(a12) else f'{a12:.2f}'}"
        for place, a12 in zip(design.places, design.shown(trials), strict=False)
    ]
    return f"The smallest A12 that it shows with a power of {power:.0%}: {', '.join(found)}."


def _design(study: Study, power: float) -> tuple[Design, int, int]:
    """Return the design of a study, its trials of each optimizer on a problem, and the instances of a problem."""
    of_function = Counter(function_of(entry.label) for entry in study.problems)
    k, instances = len(study.optimizers), min(of_function.values())
    pairs = k - 1 if study.subject else comb(k, 2)
    design = Design(len(of_function), pairs, ALPHA / pairs if study.subject else ALPHA, power)
    return design, study.trials * instances, instances


def _needed(shows: Callable[[int], bool]) -> str:
    every = range(2, MOST + 1)
    place = bisect_left(every, True, key=shows)
    return f"{every[place]:,}" if place < len(every) else f"more than {MOST:,}"
