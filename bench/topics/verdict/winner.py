"""State which optimizer ends lowest in one headline and four short lines: where, by how much, how sure, at what cost.

The evidence is the probability to end lower, in the mean over these problems, against each rival. An optimizer is named
where the test of each pair with it rejects at the level of tests over all problems: all of them must, so that none
needs an adjustment (an intersection-union test; Berger 1982, Technometrics 24). With declared looks, which spend all of
the level on single problems, it must be separably lower than each rival on more than half of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import Any, NamedTuple

import pandas as pd

from bench.analysis.error_rates import Levels
from bench.report.parts import Line
from bench.report.wording import count, listing, p_text, percent
from bench.topics.verdict.clock import Clock

NAMED = 3  # optimizers that a sentence names
WORDS = 20  # of a line, at most
PARTS = {
    "where": "Comparison",
    "by_how_much": "Across problems",
    "how_sure": "How often would this page be wrong?",
    "at_what_cost": "Convergence and targets",
}
"""The titles of the parts and cards that have the rest of a line."""

LEVEL = "at most 5% of such pages claim too much"

TIED = 1e-9  # mean ranks closer than this are the same


def winner_rule(looks: bool) -> str:
    """Return the rule, as methods sections state it, of a study with or without declared looks."""
    shown = (
        "is separably lower than each rival on more than half of the problems"
        if looks
        else "ends lower than each rival by the test over all problems, at the level and without adjustment, since all "
        "of these tests must reject (intersection-union test)"
    )
    return (
        f"An optimizer is called best if it {shown}; it is not called best where the optimizers differ in more than "
        "their algorithms."
    )


class Stage(NamedTuple):
    """A budget in words, and those that are shown to end lower there than the leader; else the leader alone."""

    spent: str
    lowest: tuple[str, ...]


class Across(NamedTuple):
    """A pair of optimizers over all problems, seen from the first one.

    Attributes:
        chance: the probability to end lower, with its 95% interval for these problems, low to high.
        further: its 95% interval for further problems.
        p: of the test over all problems, not adjusted.
        lower: whether that test shows the first one to be lower.
        beyond: whether the test for further problems shows it as well.
    """

    chance: float
    low: float
    high: float
    further: tuple[float, float]
    p: float
    lower: bool
    beyond: bool = False


class Conclusion(NamedTuple):
    """What may be claimed.

    Attributes:
        headline: one sentence of at most 25 words, and the labels and the budget in it.
        lines: at most four short answers, each with the part of the page that has the rest.
        details: the sentences that they shorten.
        clear: whether the headline names a winner under like conditions.
    """

    headline: str
    lines: tuple[Line, ...]
    details: tuple[str, ...]
    clear: bool


@dataclass(frozen=True)
class Standing:
    """What is known of one study, from which the verdict is written.

    Attributes:
        ranking: of :func:`bench.analysis.ranking`, with the place of :func:`bench.analysis.places` and rank_low and
            rank_high of :func:`bench.analysis.ranking_certainty`, in the order of the places.
        beaten: by (one, other), on how many problems one is separably lower than the other; 0 where there is none.
        across: by (one, other), the comparison over all problems.
        levels: of the tests on problems and over all of them; 0 where no test can be significant.
        blocks: the independent problems.
        budget: the full budget in words, such as "60,000 evaluations".
        problem: the label of the only problem, "" where there are several.
        trials: of a cell, in words, such as "1 trial".
        conditions: what differs between the optimizers besides their algorithms, in a clause; "" where nothing does.
        matched: what controls under equal conditions would cost, or where they are; "" where nothing differs.
        differing: the dimensions in which another one leads, in a few words; "" where there is none.
        left_out: the problems on which the optimizers are not compared.
        size: by how much the leader is lower than the second in rank, in the objective's unit or in evaluations.
        near_shares: the share of each optimizer's trials that came near the best known value; empty where unknown.
        near: what that means, in words.
        course: who is shown to end lower than the leader at smaller budgets, :class:`Stage` by stage, the full last.
        unit: of the stages, "evaluations" or "of the budget".
        clock: who is faster by the clock; None where running times in seconds do not change the order.
        sweep: that the problems are one sweep and stand for no further ones; "" where they are not.
        selected: whether optimizers or problems were selected after the results were seen.
    """

    ranking: pd.DataFrame
    beaten: Mapping[tuple[str, str], int]
    across: Mapping[tuple[str, str], Across]
    levels: Levels
    blocks: int
    budget: str
    problem: str = ""
    trials: str = ""
    conditions: str = ""
    matched: str = ""
    differing: str = ""
    left_out: Sequence[str] = ()
    size: str = ""
    near_shares: pd.Series[float] = field(default_factory=lambda: pd.Series(dtype=float))
    near: str = ""
    course: Sequence[Stage] = ()
    unit: str = "evaluations"
    clock: Clock | None = None
    sweep: str = ""
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
    def ordered(self) -> list[str]:
        """The optimizers in the order of their places."""
        return list(self.places)

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
        leader, *rivals = self.ordered
        if self.levels.across:
            return [rival for rival in rivals if not self.across[leader, rival].lower]
        return [rival for rival in rivals if not self.lower_on_most(leader, rival)]

    @property
    def beyond(self) -> bool:
        """Whether the lead is shown for further problems, too, if these are an independent sample of them."""
        leader, *rivals = self.ordered
        return bool(self.leads) and not self.sweep and all(self.across[leader, rival].beyond for rival in rivals)

    @property
    def leads(self) -> str:
        """The optimizer that is shown to be lower than every rival; "" where there is none."""
        return "" if self.open or len(self.level) > 1 else self.ordered[0]


def verdict(standing: Standing) -> Conclusion:
    """Return what may be claimed: of one problem and of many, of ties, of failures, of too few trials for a test."""
    under = ", under unlike conditions" if standing.conditions else ""
    if len(standing.level) == len(standing.ranking):
        headline = f"No optimizer leads {_on(standing)} at {standing.budget}: all are level."
        return Conclusion(headline, _lines(where=_split(standing)), (), False)
    leader = standing.ordered[0]
    alone = len(standing.level) == 1  # where several share the lead, numbers of one of them would single it out
    testable = bool(standing.levels.problems or standing.levels.across)
    lines = _lines(
        where=_where(standing, leader),
        by_how_much=_effect(standing, leader) if alone else "",
        how_sure=_sure(standing),
        at_what_cost=_cost(standing, leader) if alone and testable else "",
    )
    details = filter(
        None,
        (
            _shown(standing, leader) if standing.leads else "",
            _sizes(standing, leader) if alone else "",
            _scope(standing),
            f"The lead may come from the conditions. {standing.matched}".strip() if standing.conditions else "",
            _course(standing, leader) if alone and testable else "",
            standing.clock.sentence if standing.clock and alone and testable else "",
        ),
    )
    return Conclusion(
        f"{_headline(standing, leader)}{under}.", lines, tuple(details), bool(standing.leads and not under)
    )


def _lines(**texts: str) -> tuple[Line, ...]:
    return tuple(Line(label.replace("_", " "), text, PARTS[label]) for label, text in texts.items() if text)


def _split(standing: Standing) -> str:
    """Return who is separably lower than every rival on some problems, though others are so on as many; else ""."""
    parts = [f"{label} on {number}" for label in standing.ordered if (number := standing.row(label)["separable"])]
    differ = f"problems differ: separably lower than every rival is {listing(parts, NAMED)}" if parts else ""
    return "; ".join(filter(None, (differ, _left_out(standing))))


def _on(standing: Standing) -> str:
    return f"on {standing.problem}" if standing.problem else f"on these {standing.problems} problems"


def _headline(standing: Standing, leader: str) -> str:
    """Return who ends lowest where, or that nobody is shown to, without conditions and full stop."""
    if standing.leads:
        further = " and on further ones like them" if standing.beyond else ""
        return f"{leader} ends lowest {_on(standing)}{further} at {standing.budget}"
    start = f"No winner {_on(standing)} at {standing.budget}"
    if not (standing.levels.problems or standing.levels.across):
        return f"{start}: {_first(standing)}, untested with {standing.trials} a cell"
    if len(standing.level) > 1:
        return f"{start}: {_first(standing)}"
    return f"{start}: {_first(standing)}, but not shown to end lower than {listing(standing.open, NAMED)}"


def _first(standing: Standing) -> str:
    level = standing.level
    return f"{listing(level, NAMED)} share the first place" if len(level) > 1 else f"{level[0]} is first"


def _where(standing: Standing, leader: str) -> str:
    """Return on how many problems the leader is first, where another one is lower, and what is not compared."""
    if standing.problem:
        return _left_out(standing)
    row, separably = standing.row(leader), ""
    first = f"first on {row['first']} of {standing.problems}" if len(standing.level) == 1 else ""
    if standing.levels.problems:
        rivals = [f"{rival} on {standing.beaten.get((leader, rival), 0)}" for rival in standing.ordered[1:]]
        than = f"every rival on {row['separable']}" if standing.leads else listing(rivals, 2)
        worse = f" (a rival on {row['worse']})" if row["worse"] and not standing.differing else ""
        separably = f"separably lower than {than}{worse}"
    limits = (standing.differing, _left_out(standing))
    whole = "; ".join(filter(None, (", ".join(filter(None, (first, separably))), *limits)))
    return whole if len(whole.split()) <= WORDS else "; ".join(filter(None, (first, *limits)))


def _left_out(standing: Standing) -> str:
    """Return the problems that are not compared, each by its name where they are few; "" where there is none."""
    few = listing(standing.left_out, 2) if 0 < len(standing.left_out) <= 2 else count(len(standing.left_out), "problem")
    return f"not compared: {few}" if standing.left_out else ""


def _effect(standing: Standing, leader: str) -> str:
    """Return how often a run of the leader ends lower than one of the second."""
    second = standing.ordered[1]
    pair = standing.across[leader, second]
    if math.isnan(pair.chance) or math.isnan(pair.low):
        return ""
    place = "" if len(standing.ranking) == 2 else ", the second,"
    share = f"{percent(pair.chance)} of pairs [{100 * pair.low:.0f}, {100 * pair.high:.0f}]"
    return f"a run of {leader} ends lower than one of {second}{place} in {share}"


def _sure(standing: Standing) -> str:
    """Return the level of the claims, and what they do not cover."""
    if not (standing.levels.problems or standing.levels.across):
        return "with so few trials the order may be chance"
    scope = ""
    if standing.sweep:
        scope = "these problems are one sweep"
    elif standing.beyond:
        scope = "further problems only if independent"
    elif standing.leads and not standing.problem:
        scope = "not shown for further problems"
    conditions = "unlike conditions may explain the lead" if standing.conditions else ""
    level = "selected after the results, so no level holds" if standing.selected else LEVEL
    return "; ".join(filter(None, (level, scope, conditions)))


def _cost(standing: Standing, leader: str) -> str:
    """Return up to which budget another one ends lower than the leader, and when another one is faster by the clock."""
    parts = []
    if standing.course:
        behind = [stage for stage in standing.course if leader not in stage.lowest]
        ends = f"{listing(behind[-1].lowest, 2)} ends lower up to {behind[-1].spent} {standing.unit}" if behind else ""
        parts.append(ends or "none is shown to end lower at smaller budgets")
    if standing.clock:
        parts.append(f"by the clock {standing.clock.fastest} is faster below {standing.clock.cost} an evaluation")
    return "; ".join(parts)


def _shown(standing: Standing, leader: str) -> str:
    """Return what shows that the leader is lower than every rival."""
    rivals = standing.ordered[1:]
    every = rivals[0] if len(rivals) == 1 else f"all {len(rivals)} others"
    if not standing.levels.across:
        return (
            f"{leader} is separably lower than each other optimizer on more than half of "
            f"{count(standing.problems, 'problem')}."
        )
    most = max(standing.across[leader, rival].p for rival in rivals)
    p = p_text(most) if len(rivals) == 1 else f"{p_text(most).replace('=', '≤')} against each"
    return f"Runs of {leader} end lower than those of {every} {_on(standing)} ({p})."


def _sizes(standing: Standing, leader: str) -> str:
    """Return the intervals of the lead, its size in the objective's unit, and the share of runs near the optimum."""
    second, row = standing.ordered[1], standing.row(leader)
    pair, texts = standing.across[leader, second], []
    if not (math.isnan(pair.chance) or math.isnan(pair.low)):
        shown = f"{pair.chance:.2f} [{pair.low:.2f}, {pair.high:.2f}]"
        if not (standing.problem or standing.sweep or math.isnan(pair.further[0])):
            shown += f" on these problems, [{pair.further[0]:.2f}, {pair.further[1]:.2f}] on further ones"
        beside = [label for label in standing.ordered[2:] if standing.places[label] == standing.places[second]]
        place = f", which shares the second place with {listing(beside, NAMED)}," if beside else ""
        texts.append(f"A run of {leader} ends lower than a run of {second}{place} with probability {shown}.")
    if not standing.problem:
        interval = "" if pd.isna(row["rank_low"]) else f" [{row['rank_low']:.2f}, {row['rank_high']:.2f}]"
        texts.append(f"Its mean rank is {row['mean_rank']:.2f}{interval} of {len(standing.ranking)}.")
    return " ".join(filter(None, (*texts, standing.size, _near(standing, leader))))


def _scope(standing: Standing) -> str:
    """Return for which problems the claim holds."""
    if standing.sweep:
        return standing.sweep
    if standing.problem:
        return "This holds for this problem only."
    parts = []
    if standing.beyond:
        parts.append("The lead holds for further problems, too, if these are an independent sample of them.")
    elif standing.leads:
        blocks = count(standing.blocks, "independent problem")
        parts.append(f"The lead is not shown for further problems, of which these would be a sample of {blocks}.")
    if not standing.levels.problems and standing.levels.across:
        parts.append(f"With {standing.trials} a cell nothing is tested on single problems.")
    return " ".join(parts)


def _near(standing: Standing, leader: str) -> str:
    """Return the share of runs that came near the best known value, with that of the best rival."""
    if standing.near_shares.empty or not standing.near_shares.max() > 0:
        return ""
    of_rivals = standing.near_shares.drop(leader)
    best, most, share = str(of_rivals.idxmax()), float(of_rivals.max()), float(standing.near_shares[leader])
    if not share:
        return f"None of its runs comes {standing.near}, but {percent(most)} of {best}’s do."
    beside = f"{best} {percent(most)}" if most > 0 else "no other run does"
    return f"{percent(share)} of its runs come {standing.near} ({beside})."


def _course(standing: Standing, leader: str) -> str:
    """Return who is shown to end lower than the leader at which smaller budgets; "" where that is not known."""
    if not standing.course or leader not in standing.course[-1].lowest:
        return ""
    spells = []
    for lowest, spell in groupby(standing.course, lambda stage: (leader,) if leader in stage.lowest else stage.lowest):
        spent = [stage.spent for stage in spell]
        if leader not in lowest:
            when = f"at {spent[0]}" if len(spent) == 1 else f"from {spent[0]} to {spent[-1]}"
            spells.append(f"{listing(lowest, NAMED)} {when}")
    if not spells:
        return "At no smaller budget is another one shown to end lower."
    return f"Shown to end lower than {leader} at smaller budgets: {listing(spells)} {standing.unit}."
