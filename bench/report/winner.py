"""State in one paragraph which optimizer is best, by how much, how sure that is, and at what budget."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, NamedTuple

import pandas as pd

from bench.analysis import ALPHA
from bench.report.wording import count, listing

NAMED = 4  # optimizers that a sentence names
SURE = 0.995  # share of repetitions that a sentence calls practically all
TIED = 1e-9  # mean ranks closer than this are the same


class Stage(NamedTuple):
    """A budget in words, and the optimizers with the lowest mean rank there, several where they tie."""

    spent: str
    lowest: tuple[str, ...]


@dataclass(frozen=True)
class Standing:
    """What is known of one study, from which the paragraph is written.

    Attributes:
        ranking: of :func:`bench.analysis.ranking`, with first_low, first_high, rank_low, rank_high and leads of
            :func:`bench.analysis.ranking_certainty`.
        beaten: by (one, other), on how many problems one is separably lower than the other; 0 where there is none.
        chances: by (one, other), the mean over problems of A12, with the ends of its 95 % interval.
        testable: whether any test can be significant with the trials there are.
        budget: the full budget in words, such as "60,000 evaluations".
        problem: the label of the only problem, "" where there are several.
        found: the share of each optimizer's trials that came near the best known value; empty where unknown.
        near: what that means, in words.
        course: who has the lowest mean rank at smaller budgets, :class:`Stage` by stage, the full budget last.
        unit: of the stages, "evaluations" or "of the budget".
        clock: the sentence on running times in seconds; "" where these do not change the order.
        trials: in words, such as "1 trial".
    """

    ranking: pd.DataFrame
    beaten: Mapping[tuple[str, str], int]
    chances: Mapping[tuple[str, str], tuple[float, float, float]]
    testable: bool
    budget: str
    problem: str = ""
    found: pd.Series[float] = field(default_factory=lambda: pd.Series(dtype=float))
    near: str = ""
    course: Sequence[Stage] = ()
    unit: str = "evaluations"
    clock: str = ""
    trials: str = ""

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
        against = {one: sum(self.chances[one, other][0] for other in labels if other != one) for one in labels}
        ranks = dict(zip(labels, self.ranking["mean_rank"].round(9), strict=True))
        return sorted(labels, key=lambda each: (ranks[each], -round(against[each], 9)))

    @property
    def level(self) -> list[str]:
        """The optimizers that share the lowest mean rank."""
        ranks = self.ranking.set_index("optimizer")["mean_rank"]
        return [each for each in self.ordered if ranks[each] <= ranks.min() + TIED]

    @property
    def open(self) -> list[str]:
        """The rivals than which the leader is separably lower on half of the problems at most, in order of rank."""
        leader, *rivals = self.ordered
        return [each for each in rivals if 2 * self.beaten.get((leader, each), 0) <= self.problems]

    @property
    def winner(self) -> str:
        """The optimizer that is separably lower than every rival on most problems; "" where there is none."""
        return "" if self.open or len(self.level) > 1 else self.ordered[0]


def paragraph(known: Standing) -> str:
    """Return the paragraph: true of one problem and of many, of ties, of failures, and of too few trials for a test."""
    if len(known.level) == len(known.ranking):
        return f"No optimizer leads at {known.budget}: all have the same mean rank {_over(known)}.{_split(known)}"
    leader = known.ordered[0]
    sentences = [_who(known, leader), _beyond(known)]
    if len(known.level) == 1:  # where several share the lead, numbers of one of them would single it out
        sentences += [_certainty(known, leader), _effect(known, leader)]
        if known.testable:
            sentences += [_found(known, leader), _course(known, leader), known.clock]
    return " ".join(filter(None, sentences))


def _split(known: Standing) -> str:
    """Return who is separably lower than every rival on some problems, though others are so on as many; else ""."""
    parts = [f"{each} on {number}" for each in known.ordered if (number := known.row(each)["separable"])]
    return f" But problems differ: separably lower than every rival is {listing(parts)}." if parts else ""


def _over(known: Standing) -> str:
    return f"on {known.problem}" if known.problem else f"over {known.problems} problems"


def _who(known: Standing, leader: str) -> str:
    if known.winner:
        return _named(known, leader)
    row = known.row(leader)
    if len(known.level) > 1:
        lead = f"{listing(known.level, NAMED)} share the lowest mean rank {_over(known)}"
    elif known.problem:
        lead = f"{leader} ranks first on {known.problem}"
    else:
        lead = f"{leader} has the lowest mean rank {_over(known)} ({row['mean_rank']:.2f} of {len(known.ranking)})"
    if not known.testable:
        return (
            f"No winner can be named at {known.budget}: with {known.trials} a cell no test can be significant. {lead}, "
            "which may be chance."
        )
    if len(known.level) > 1:
        return f"No single winner at {known.budget}: {lead}."
    open_rivals = (
        known.open if known.problem else [f"{each} ({known.beaten.get((leader, each), 0)})" for each in known.open]
    )
    those = listing(open_rivals, NAMED)
    if known.problem:
        return f"No single winner at {known.budget}: {lead}, but is not separably lower than {those}."
    those = listing([f"{each} ({known.beaten.get((leader, each), 0)})" for each in known.open], NAMED)
    worse = f" On {count(row['worse'], 'problem')} another one is separably lower than it." if row["worse"] else ""
    return (
        f"No single winner at {known.budget}: {lead}, but is separably lower on at most half of the problems than "
        f"{those}.{worse}"
    )


def _named(known: Standing, leader: str) -> str:
    """Return the sentence that names the winner."""
    row = known.row(leader)
    rivals = known.ordered[1:]
    every = rivals[0] if len(rivals) == 1 else f"all {len(rivals)} others"
    best = f"{leader} is best {f'on {known.problem} ' if known.problem else ''}at {known.budget}"
    if known.problem:
        return f"{best}: its results are separably lower than those of {every}."
    problems = count(known.problems, "problem")
    worse = f"significantly worse than another on {row['worse']}" if row["worse"] else "significantly worse on none"
    if 2 * row["separable"] > known.problems:
        return f"{best}: separably lower than {every} on {row['separable']} of {problems}, and {worse}."
    return (  # than each of them on most problems, but seldom than all at once
        f"{best}: separably lower than each other optimizer on more than half of {problems}, than {every} at once on "
        f"{row['separable']}, and {worse}."
    )


def _beyond(known: Standing) -> str:
    """Return that nothing is claimed of other problems, where no test of a pair across problems can be significant."""
    if known.problem:
        return "This holds for this problem only."
    if not too_few_problems(known.problems, math.comb(len(known.ranking), 2)):
        return ""
    return (
        f"This holds for these {known.problems} problems only: they are too few for a test across problems to "
        "distinguish any two optimizers."
    )


def too_few_problems(problems: int, pairs: int) -> bool:
    """Return whether no Wilcoxon test across problems can be significant, with Holm's adjustment over the pairs.

    The smallest two-sided p-value, that of differences of one sign alone, is 2 / 2^problems.
    """
    return 2.0 ** (1 - problems) > ALPHA / max(pairs, 1)


def _certainty(known: Standing, leader: str) -> str:
    """Return the interval of the number of first ranks, and in how many repetitions the leader would lead."""
    row = known.row(leader)
    if known.problem or pd.isna(row["first_low"]):
        return ""
    often = "practically every repetition" if row["leads"] >= SURE else f"{row['leads']:.0%} of repetitions"
    return (
        f"It is ranked first on {row['first']} [{row['first_low']:.0f}, {row['first_high']:.0f}] of "
        f"{known.problems}, and would lead in {often} of these trials."
    )


def _effect(known: Standing, leader: str) -> str:
    second = known.ordered[1]
    chance, low, high = known.chances[leader, second]
    if math.isnan(chance):
        return ""
    shown = "" if math.isnan(low) else f" [{low:.2f}, {high:.2f}]"
    ranks = known.ranking.set_index("optimizer")["mean_rank"]
    beside = [each for each in known.ordered[2:] if ranks[each] <= ranks[second] + TIED]
    place = f", which shares the second rank with {listing(beside, NAMED)}," if beside else ", the second in rank,"
    place = "" if len(known.ranking) == 2 else place
    return f"A run of it beats a run of {second}{place} with probability {chance:.2f}{shown}."


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
    """Return who has a lower mean rank than the leader at which smaller budgets, or that nobody has."""
    if not known.course or leader not in known.course[-1].lowest:
        return ""
    spells = []
    for lowest, own in groupby(known.course, lambda stage: (leader,) if leader in stage.lowest else stage.lowest):
        spent = [stage.spent for stage in own]
        if leader not in lowest:
            when = f"at {spent[0]}" if len(spent) == 1 else f"from {spent[0]} to {spent[-1]}"
            spells.append(f"{listing(lowest, NAMED)} {when}")
    if not spells:
        return f"From {known.course[0].spent} {known.unit} on, no other has a lower mean rank."
    return f"At smaller budgets the lowest mean rank is that of {listing(spells)} {known.unit}."


def percent(share: float) -> str:
    """Return a share in percent, which is 0% or 100% for none and all alone."""
    return "<1%" if 0 < share < 0.005 else ">99%" if 0.995 <= share < 1 else f"{share:.0%}"
