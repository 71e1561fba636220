"""State which optimizer is best in one headline and four short lines: where, by how much, how sure, at what budget.

Two kinds of evidence can name a winner, and the design of the study alone decides which of them may speak
(:func:`bench.analysis.levels`): tests of the trials on each problem, and tests over all problems. Both are adjusted for
all that they compare, so all claims together err with alpha at most.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, NamedTuple

import pandas as pd

from bench.analysis.error_rates import Levels
from bench.report.wording import count, listing, p_text, percent

NAMED = 4  # optimizers that a sentence names
TIED = 1e-9  # mean ranks closer than this are the same

WINNER_RULE = (
    "An optimizer is called best if, against each rival, it is separably lower on more than half of the problems, or "
    "if the test over all problems shows it lower than each rival; it is not called best where the optimizers differ "
    "in more than their algorithms."
)
"""The rule, as methods sections state it."""


class Stage(NamedTuple):
    """A budget in words, and the optimizers with the lowest mean rank there, several where they tie."""

    spent: str
    lowest: tuple[str, ...]


class Across(NamedTuple):
    """A pair of optimizers over all problems, seen from the first one.

    Attributes:
        chance: the mean over problems of A12, with its 95 % interval for these problems, low to high.
        further: its 95 % interval for further problems; missing where they are too few.
        p: of the test over all problems, adjusted over all pairs.
        lower: whether that test shows the first one to be lower.
    """

    chance: float
    low: float
    high: float
    further: tuple[float, float]
    p: float
    lower: bool


class Conclusion(NamedTuple):
    """What may be claimed.

    Attributes:
        headline: one sentence.
        lines: short lines, (label, text).
        clear: whether the headline names a best optimizer.
    """

    headline: str
    lines: tuple[tuple[str, str], ...]
    clear: bool


@dataclass(frozen=True)
class Standing:
    """What is known of one study, from which the verdict is written.

    Attributes:
        ranking: of :func:`bench.analysis.ranking`, with rank_low and rank_high of
            :func:`bench.analysis.ranking_certainty`.
        beaten: by (one, other), on how many problems one is separably lower than the other; 0 where there is none.
        across: by (one, other), the comparison over all problems.
        levels: of the tests on problems and over all of them; 0 where no test can be significant.
        blocks: the independent problems.
        budget: the full budget in words, such as "60,000 evaluations".
        problem: the label of the only problem, "" where there are several.
        trials: of a cell, in words, such as "1 trial".
        conditions: what differs between the optimizers besides their algorithms, in a clause; "" where nothing does.
        matched: what controls under equal conditions would cost, or where they are; "" where nothing differs.
        differing: the leader of each dimension in which another one leads, in words; "" where there is none.
        size: by how much the leader is lower than the second in rank, in the objective's unit or in evaluations.
        found: the share of each optimizer's trials that came near the best known value; empty where unknown.
        near: what that means, in words.
        course: who has the lowest mean rank at smaller budgets, :class:`Stage` by stage, the full budget last.
        unit: of the stages, "evaluations" or "of the budget".
        clock: the sentence on running times in seconds; "" where these do not change the order.
        sweep: that the problems are one sweep and stand for no further ones; "" where they are not.
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
    size: str = ""
    found: pd.Series[float] = field(default_factory=lambda: pd.Series(dtype=float))
    near: str = ""
    course: Sequence[Stage] = ()
    unit: str = "evaluations"
    clock: str = ""
    sweep: str = ""

    @property
    def problems(self) -> int:
        """The number of problems on which every optimizer has a trial."""
        return int(self.ranking["problems"].iloc[0])

    def row(self, optimizer: str) -> dict[str, Any]:
        """Return the row of an optimizer in the ranking."""
        own = self.ranking[self.ranking["optimizer"] == optimizer].iloc[0]
        counts = {name: int(own[name]) for name in ("first", "separable", "worse")}
        return {str(name): value for name, value in own.items()} | counts

    @property
    def ordered(self) -> list[str]:
        """The optimizers by mean rank, and by the mean chance to beat another where they tie."""
        labels = list(self.ranking["optimizer"])
        chances = {pair: 0.5 if math.isnan(each.chance) else each.chance for pair, each in self.across.items()}
        against = {one: sum(chances[one, other] for other in labels if other != one) for one in labels}
        ranks = dict(zip(labels, self.ranking["mean_rank"].round(9), strict=True))
        return sorted(labels, key=lambda each: (ranks[each], -round(float(against[each]), 9)))

    @property
    def level(self) -> list[str]:
        """The optimizers that share the lowest mean rank."""
        ranks = self.ranking.set_index("optimizer")["mean_rank"]
        return [each for each in self.ordered if ranks[each] <= ranks.min() + TIED]

    def lower_on_most(self, one: str, other: str) -> bool:
        """Return whether one is separably lower than the other on more than half of the problems."""
        return 2 * self.beaten.get((one, other), 0) > self.problems

    @property
    def open(self) -> list[str]:
        """The rivals than which neither kind of evidence shows the leader to be lower, in order of rank."""
        leader, *rivals = self.ordered
        kinds = [
            [each for each in rivals if not self.lower_on_most(leader, each)],
            [each for each in rivals if not self.across[leader, each].lower],
        ]
        return min(kinds, key=len)

    @property
    def leads(self) -> str:
        """The optimizer that is shown to be lower than every rival; "" where there is none."""
        return "" if self.open or len(self.level) > 1 else self.ordered[0]


def verdict(known: Standing) -> Conclusion:
    """Return what may be claimed: of one problem and of many, of ties, of failures, of too few trials for a test."""
    if len(known.level) == len(known.ranking):
        headline = f"No optimizer leads at {known.budget}: all have the same mean rank {_over(known)}."
        return Conclusion(headline, _lines(Where=_split(known)), False)
    leader = known.ordered[0]
    alone = len(known.level) == 1  # where several share the lead, numbers of one of them would single it out
    testable = bool(known.levels.problems or known.levels.across)
    lines = _lines(
        Where=_where(known, leader),
        By_how_much=_effect(known, leader) if alone else "",
        How_sure=_sure(known, leader),
        At_what_budget=_course(known, leader) if alone and testable else "",
    )
    return Conclusion(_headline(known, leader), lines, bool(known.leads) and not known.conditions)


def _lines(**texts: str) -> tuple[tuple[str, str], ...]:
    return tuple((label.replace("_", " "), text) for label, text in texts.items() if text)


def _split(known: Standing) -> str:
    """Return who is separably lower than every rival on some problems, though others are so on as many; else ""."""
    parts = [f"{each} on {number}" for each in known.ordered if (number := known.row(each)["separable"])]
    return f"Problems differ: separably lower than every rival is {listing(parts)}." if parts else ""


def _over(known: Standing) -> str:
    return f"on {known.problem}" if known.problem else f"over {known.problems} problems"


def _headline(known: Standing, leader: str) -> str:
    """Return who leads, or that nobody is shown to; conditions that differ come before the verb."""
    under = f"Under different conditions ({known.conditions}), " if known.conditions else ""
    if known.leads:
        where = f"on {known.problem} " if known.problem else ""
        if not under:
            return f"{leader} is best {where}at {known.budget}: {_shown(known, leader)}."
        return f"{under}{leader} ends lowest {where}at {known.budget}: {_shown(known, leader)}."
    if len(known.level) > 1:
        lead = f"{listing(known.level, NAMED)} share the lowest mean rank {_over(known)}"
    elif known.problem:
        lead = f"{leader} ranks first on {known.problem}"
    else:
        lead = f"{leader} has the lowest mean rank {_over(known)}"
    if not (known.levels.problems or known.levels.across):
        few = f"{known.trials} a cell" + ("" if known.problem else f" on {count(known.blocks, 'independent problem')}")
        return (
            f"No winner can be named at {known.budget}: with {few} no test can be significant. {under}{lead}, which "
            "may be chance."
        )
    start = f"No single winner at {known.budget}: {under[:1].lower()}{under[1:]}{lead}"
    if len(known.level) > 1:
        return f"{start}."
    return f"{start}, but is not shown to be lower than {listing(known.open, NAMED)}."


def _shown(known: Standing, leader: str) -> str:
    """Return what shows that the leader is lower than every rival."""
    rivals = known.ordered[1:]
    every = rivals[0] if len(rivals) == 1 else f"all {len(rivals)} others"
    if known.problem:
        return f"its results are separably lower than those of {every}"
    texts = []
    if all(known.lower_on_most(leader, each) for each in rivals):
        number, problems = known.row(leader)["separable"], count(known.problems, "problem")
        texts.append(
            f"separably lower than {every} on {number} of {problems}"
            if 2 * number > known.problems
            else f"separably lower than each other optimizer on more than half of {problems}"
        )
    if all(known.across[leader, each].lower for each in rivals):
        most = max(known.across[leader, each].p for each in rivals)
        p, which = (p_text(most), "") if len(rivals) == 1 else (p_text(most).replace("=", "≤"), " against each")
        over = "across problems" if known.levels.further else f"in the mean over these {known.problems} problems"
        texts.append(f"lower than {every} {over} ({p}{which})")
    return ", and ".join(texts)


def _where(known: Standing, leader: str) -> str:
    """Return on how many problems the leader is first, and where another one is lower."""
    if known.problem:
        return "This holds for this problem only."
    row, parts = known.row(leader), []
    if len(known.level) == 1:
        parts.append(f"ranked first on {row['first']} of {known.problems}")
    if known.levels.problems:
        rivals = known.ordered[1:]
        if not known.leads:
            own = [f"{each} {known.beaten.get((leader, each), 0)}" for each in rivals[:NAMED]]
            parts.append(f"separably lower than {listing(own)}")
        elif not all(known.lower_on_most(leader, each) for each in rivals):
            parts.append(f"separably lower than every rival on {row['separable']}")
        parts.append(
            f"a rival is separably lower on {row['worse']}" if row["worse"] else "no rival is separably lower on any"
        )
    text = f"{leader}: {'; '.join(parts)}." if parts else ""
    return " ".join(filter(None, (text, known.differing)))


def _effect(known: Standing, leader: str) -> str:
    """Return by how much the leader is lower than the second in rank."""
    second = known.ordered[1]
    pair = known.across[leader, second]
    if math.isnan(pair.chance) or math.isnan(pair.low):
        return ""
    ranks = known.ranking.set_index("optimizer")["mean_rank"]
    beside = [each for each in known.ordered[2:] if ranks[each] <= ranks[second] + TIED]
    place = f", which shares the second rank with {listing(beside, NAMED)}," if beside else ", the second in rank,"
    place = "" if len(known.ranking) == 2 else place
    shown = f"{pair.chance:.2f} [{pair.low:.2f}, {pair.high:.2f}]"
    if not math.isnan(pair.further[0]):
        shown += f" on these problems, [{pair.further[0]:.2f}, {pair.further[1]:.2f}] on further ones like them"
    text = f"A run of {leader} beats a run of {second}{place} with probability {shown}."
    return " ".join(filter(None, (text, known.size, _found(known, leader))))


def _sure(known: Standing, leader: str) -> str:
    """Return what the claim does not cover, and the interval of the leader's mean rank."""
    parts = []
    row = known.row(leader)
    if not known.problem and len(known.level) == 1:
        interval = "" if pd.isna(row["rank_low"]) else f" [{row['rank_low']:.2f}, {row['rank_high']:.2f}]"
        parts.append(f"Mean rank {row['mean_rank']:.2f}{interval} of {len(known.ranking)}.")
    if known.sweep:
        parts.append(known.sweep)
    elif not known.problem and not (known.levels.further and known.levels.across):
        few = f"{count(known.blocks, 'independent problem')} {'is' if known.blocks == 1 else 'are'} too few"
        parts.append(f"This holds for these {known.problems} problems only: {few} for a test of others.")
    if not known.problem and not known.levels.problems and known.levels.across:
        parts.append(f"With {known.trials} a cell nothing is tested on single problems.")
    if known.conditions:
        parts.append(f"The lead may come from the conditions. {known.matched}".strip())
    return " ".join(parts)


def _found(known: Standing, leader: str) -> str:
    """Return the share of runs that came near the best known value, with that of the best rival."""
    if known.found.empty or not known.found.max() > 0:
        return ""
    others = known.found.drop(leader)
    best, most, own = str(others.idxmax()), float(others.max()), float(known.found[leader])
    if not own:
        return f"None of its runs comes {known.near}, but {percent(most)} of {best}’s do."
    rest = f"{best} {percent(most)}" if most > 0 else "no other run does"
    return f"{percent(own)} of its runs come {known.near} ({rest})."


def _course(known: Standing, leader: str) -> str:
    """Return who has a lower mean rank than the leader at which smaller budgets, and who is faster by the clock."""
    return " ".join(filter(None, (_stages(known, leader), known.clock)))


def _stages(known: Standing, leader: str) -> str:
    if not known.course or leader not in known.course[-1].lowest:
        return ""
    spells = []
    for lowest, own in groupby(known.course, lambda stage: (leader,) if leader in stage.lowest else stage.lowest):
        spent = [stage.spent for stage in own]
        if leader not in lowest:
            when = f"at {spent[0]}" if len(spent) == 1 else f"from {spent[0]} to {spent[-1]}"
            spells.append(f"{listing(lowest, NAMED)} {when}")
    if not spells:
        first = known.course[0].spent
        unit = "evaluation" if (first, known.unit) == ("1", "evaluations") else known.unit
        return f"From {first} {unit} on, no other has a lower mean rank."
    return f"At smaller budgets the lowest mean rank is that of {listing(spells)} {known.unit}."
