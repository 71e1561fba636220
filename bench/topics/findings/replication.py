"""How many trials the cells of a study hold, in words: of problems, and of functions whose instances are pooled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from bench.report.wording import count, listing


@dataclass(frozen=True)
class Replication:
    """The trials of the cells on problems that stand for equally many instances.

    Attributes:
        problems: the number of these problems.
        instances: of each problem; 1 where a problem stands for itself.
        fewest: trials of a cell, of those that have any; 0 where none has.
        most: likewise.
        planned: trials of an optimizer on an instance; 0 where no plan is known.
    """

    problems: int
    instances: int
    fewest: int
    most: int
    planned: int = 0

    def words(self, noun: str = "trial") -> str:
        """Return ``"5 trials"``, ``"15 trials (5 on each of 3 instances)"`` or ``"4 to 5 trials (of 5 planned)"``."""
        planned, pooled = self.planned * self.instances, self.instances > 1
        made = count(self.most, noun) if self.fewest == self.most else f"{self.fewest:,} to {count(self.most, noun)}"
        split = f"{self.planned:,} on each of {self.instances:,} instances" if self.planned and pooled else ""
        if self.planned and not self.fewest == self.most == planned:
            return f"{made} (of {planned:,} planned{f', {split}' if split else ''})"
        split = split or (f"on {self.instances:,} instances" if pooled else "")
        return f"{made} ({split})" if split else made


def replications(
    coverage: pd.DataFrame, members: Mapping[str, Sequence[str]], planned: Mapping[str, int]
) -> list[Replication]:
    """Return the trials of the cells by the number of instances of their problem, most problems first.

    Args:
        coverage: stored trials by problem and optimizer (:func:`bench.analysis.coverage`).
        members: the instances that each problem stands for, by label.
        planned: trials of each optimizer on an instance, 0 where no plan is known.
    """
    stored = coverage[coverage["stored"] > 0]
    instances = stored["problem"].astype(object).map({label: len(rows) for label, rows in members.items()})
    plans = set(planned.values())
    plan = plans.pop() if len(plans) == 1 else 0
    cells = [
        Replication(rows["problem"].nunique(), int(number), int(rows["stored"].min()), int(rows["stored"].max()), plan)
        for number, rows in stored.groupby(instances.astype(int))
    ]
    return sorted(cells, key=lambda replication: -replication.problems)


def each_problem(cells: Sequence[Replication], noun: str = "trial") -> str:
    """Return how many trials an optimizer has on a problem: ``"5 trials each"``, or by problem where that differs."""
    if not cells:
        return "no trial yet"
    if len(cells) == 1:
        return f"{cells[0].words(noun)} each"
    return listing([f"{cell.words(noun)} on each of {count(cell.problems, 'problem')}" for cell in cells])
