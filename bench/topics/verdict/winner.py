"""State the optimizer that ends lowest in one headline and four lines: where, by how much, how sure, at what cost.

The evidence is the probability to end lower, in the mean over these problems, against each rival. An optimizer is named
where the test of each pair with it rejects at the level of tests over all problems: all of them must, so that none
needs an adjustment (an intersection-union test; Berger 1982, Technometrics 24).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import Any, NamedTuple

import pandas as pd

from bench.analysis.error_rates import Levels
from bench.report.parts import Line
from bench.report.prose import speaker
from bench.report.wording import listing
from bench.topics.conditions.differing import Differing
from bench.topics.verdict.clock import Clock

NAMED = 3  # optimizers that a sentence names
WORDS = 20  # of a line, at most
PARTS = {
    "where": "Comparison",
    "by_how_much": "Across problems",
    "how_sure": "How often would this page be wrong?",
    "at_what_cost": "Convergence and targets",
    "conditions": "The numbers behind it",
}
"""The titles of the parts and cards that have the rest of a line."""

TIED = 1e-9  # mean ranks closer than this are the same


def winner_rule() -> str:
    """Return the rule as methods sections state it."""
    return speaker(__package__)("rule")


class Stage(NamedTuple):
    """A budget in words, and those that are shown to end lower there than the leader; else the leader alone."""

    spent: str
    lowest: tuple[str, ...]


class Across(NamedTuple):
    """A pair of optimizers over all problems, seen from the first one.

    Attributes:
        chance: the probability to end lower, with its 95% interval for these problems, low to high.
        p: of the test over all problems, not adjusted.
        lower: whether that test shows the first one to be lower.
    """

    chance: float
    low: float
    high: float
    p: float
    lower: bool


class Conclusion(NamedTuple):
    """The claims that the tests allow.

    Attributes:
        headline: one sentence of at most 25 words, and the labels and the budget in it.
        lines: at most five short answers, each with the part of the page that has the rest.
        details: the sentences that they shorten.
        clear: whether the headline names a winner under like conditions.
    """

    headline: str
    lines: tuple[Line, ...]
    details: tuple[str, ...]
    clear: bool


@dataclass(frozen=True)
class Standing:
    """The facts on one study from which the verdict is written.

    Attributes:
        ranking: of :func:`bench.analysis.ranking`, with the place of :func:`bench.analysis.places` , in
            the order of the places.
        beaten: by (one, other), on how many problems one is separably lower than the other; 0 where there is none.
        across: by (one, other), the comparison over all problems.
        levels: of the tests on problems and over all of them; 0 where no test can be significant.
        budget: the full budget in words, such as "60,000 evaluations".
        problem: the label of the only problem, "" where there are several.
        trials: of a cell, in words, such as "1 trial".
        unlike: what may explain the lead besides the algorithm.
        differing: the dimensions in which another one leads, in a few words; "" where there is none.
        left_out: the problems on which the optimizers are not compared.
        size: by how much the leader is lower than the second in rank, in the objective's unit or in evaluations.
        near_shares: the share of each optimizer's trials that came near the best known value; empty where unknown.
        near: what that means, in words.
        course: who is shown to end lower than the leader at smaller budgets, :class:`Stage` by stage, the full last.
        unit: of the stages, "evaluations" or "of the budget".
        clock: who is faster by the clock; None where running times in seconds do not change the order.
        selected: whether optimizers or problems were selected after the results were seen.
    """

    ranking: pd.DataFrame
    beaten: Mapping[tuple[str, str], int]
    across: Mapping[tuple[str, str], Across]
    levels: Levels
    budget: str
    problem: str = ""
    trials: str = ""
    unlike: Differing = Differing()  # noqa: RUF009
    differing: str = ""
    left_out: Sequence[str] = ()
    size: str = ""
    near_shares: pd.Series[float] = field(default_factory=lambda: pd.Series(dtype=float))
    near: str = ""
    course: Sequence[Stage] = ()
    unit: str = "evaluations"
    clock: Clock | None = None
    selected: bool = False

    @property
    def problems(self) -> int:
        """The number of problems on which every optimizer has a trial."""
        return int(self.ranking["problems"].iloc[0])

    def row(self, optimizer: str) -> dict[str, Any]:
        """Return the row of an optimizer in the ranking."""
        ranked = self.ranking[self.ranking["optimizer"] == optimizer].iloc[0]
        counts = {name: int(ranked[name]) for name in ("first", "separable", "worse")}
        return {str(name): value for name, value in ranked.items()} | counts

    @cached_property
    def places(self) -> dict[str, float]:
        """The place of each optimizer over the problems; those that tie share one."""
        return dict(zip(self.ranking["optimizer"], self.ranking["place"], strict=True))

    @property
    def labels(self) -> list[str]:
        """The optimizers in the order of their places."""
        return list(self.places)

    @property
    def all_level(self) -> bool:
        """Whether all optimizers share the first place."""
        return len(self.level) == len(self.places)

    @property
    def testable(self) -> bool:
        """Whether any test can be significant."""
        return bool(self.levels.problems or self.levels.across)

    @property
    def level(self) -> list[str]:
        """The optimizers that share the first place."""
        return [label for label, place in self.places.items() if place == min(self.places.values())]

    def lower_on_most(self, label: str, rival: str) -> bool:
        """Return whether one is separably lower than the other on more than half of the problems."""
        return 2 * self.beaten.get((label, rival), 0) > self.problems

    @property
    def open(self) -> list[str]:
        """The rivals than which the leader is not shown to be lower, in their order."""
        leader, *rivals = self.labels
        if self.levels.across:
            return [rival for rival in rivals if not self.across[leader, rival].lower]
        return [rival for rival in rivals if not self.lower_on_most(leader, rival)]

    @property
    def leads(self) -> str:
        """The optimizer that is shown to be lower than every rival; "" where there is none."""
        return "" if self.open or len(self.level) > 1 else self.labels[0]


def verdict(standing: Standing) -> Conclusion:
    """Return the claims that the tests allow, of one problem or many, with ties, failures or few trials."""
    leader, second, *_ = standing.labels
    say = speaker(__package__, it=standing, leader=leader, second=second, NAMED=NAMED)
    if standing.all_level:
        owners = [f"{label} on {number}" for label in standing.labels if (number := standing.row(label)["separable"])]
        where = _joined(say("problems_differ", owners), say("left_out"))
        return Conclusion(say("headline"), _lines(where=where), (), False)
    pair, course = standing.across[leader, second], ""
    alone = len(standing.level) == 1  # where several share the lead, numbers of one of them would single it out
    measured = alone and not (math.isnan(pair.chance) or math.isnan(pair.low))
    behind = [stage for stage in standing.course if leader not in stage.lowest]
    if alone and standing.testable and standing.course and leader in standing.course[-1].lowest:
        course = say("course", _spells(standing.course, leader))
    lines = _lines(
        where=_where(standing, leader, say),
        by_how_much=say("by_how_much", pair) if measured else "",
        how_sure=say("how_sure"),
        at_what_cost=say("at_what_cost", behind) if alone and standing.testable else "",
        conditions=standing.unlike.line,
    )
    details = (
        say("shown", max(standing.across[leader, rival].p for rival in standing.labels[1:])) if standing.leads else "",
        _sizes(standing, pair, say) if alone else "",
        say("scope"),
        say("conditions"),
        course,
        standing.clock.sentence if standing.clock and alone and standing.testable else "",
    )
    clear = bool(standing.leads and not standing.unlike.clause)
    return Conclusion(say("headline"), lines, tuple(filter(None, details)), clear)


def _lines(**texts: str) -> tuple[Line, ...]:
    return tuple(Line(label.replace("_", " "), text, PARTS[label]) for label, text in texts.items() if text)


def _joined(*clauses: str) -> str:
    return "; ".join(filter(None, clauses))


def _where(standing: Standing, leader: str, say: Callable[..., str]) -> str:
    """Return on how many problems the leader is first, where another one is lower, and what is not compared."""
    if standing.problem:
        return say("left_out")
    row, limits = standing.row(leader), (standing.differing, say("left_out"))
    first = say("first_on", row["first"]) if len(standing.level) == 1 else ""
    beaten = [f"{rival} on {standing.beaten.get((leader, rival), 0)}" for rival in standing.labels[1:]]
    separably = say("separably", row, beaten) if standing.levels.problems else ""
    whole = _joined(", ".join(filter(None, (first, separably))), *limits)
    return whole if len(whole.split()) <= WORDS else _joined(first, *limits)


def _sizes(standing: Standing, pair: Across, say: Callable[..., str]) -> str:
    """Return the intervals of the lead, its size in the objective's unit, and the share of runs near the optimum."""
    leader, second, *others = standing.labels
    beside = [label for label in others if standing.places[label] == standing.places[second]]
    rank, near, shares = "", "", standing.near_shares
    if not standing.problem:
        rank = say("mean_rank", standing.row(leader))
    if not shares.empty and shares.max() > 0:
        of_rivals = shares.drop(leader)
        near = say("near", float(shares[leader]), str(of_rivals.idxmax()), float(of_rivals.max()))
    return " ".join(filter(None, (say("lead", pair, beside), rank, standing.size, near)))


def _spells(course: Sequence[Stage], leader: str) -> list[str]:
    """Return the optimizers shown to be lower than the leader, with their budgets, neighbouring ones joined."""
    spells = []
    for lowest, spell in groupby(course, lambda stage: (leader,) if leader in stage.lowest else stage.lowest):
        spent = [stage.spent for stage in spell]
        if leader not in lowest:
            when = f"at {spent[0]}" if len(spent) == 1 else f"from {spent[0]} to {spent[-1]}"
            spells.append(f"{listing(lowest, NAMED)} {when}")
    return spells
