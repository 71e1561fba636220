"""Plan a run: the missing trials of a study or shard, their number, and an estimate of their duration."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

from bench.helpers.errors import BenchError
from bench.storage.reading import Key
from bench.storage.store import CellCounts
from bench.study import Study
from bench.study.cell import Labels
from bench.trial.columns import Row
from bench.trial.trial import Trial

EXPENSIVE = 1.0
"""Seconds of an evaluation from which on none is made that nobody asked for, but for one at the best point of a run."""


@dataclass(frozen=True)
class Shard:
    """One part of a study for one machine of several: every ``of``-th trial of its plan, from the ``number``-th on."""

    number: int
    of: int

    @classmethod
    def parse(cls, text: str) -> Shard:
        """Return the shard of a text such as ``"3/20"``; raises BenchError for any other."""
        numbers = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text.strip())
        if not numbers or not 1 <= int(numbers[1]) <= int(numbers[2]):
            raise BenchError(f"a shard is its number (from 1) and the number of shards, as in 3/20, not {text!r}")
        return cls(int(numbers[1]), int(numbers[2]))

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"


@dataclass(frozen=True)
class Plan:
    """The trials of a study, or of one shard of it, and which of them are finished."""

    study: Study
    shard: Shard | None  # the part to run, None for the whole study
    finished: set[Key]  # the trials that need not be made; a run adds those that it makes
    cells: Sequence[CellCounts] = ()  # of the trials that the folder holds
    notes: Sequence[str] = ()  # warnings to print before the run begins
    seeds: Mapping[Labels, Labels] = field(default_factory=dict)  # of cells: the labels that seeds are made from
    doubtful: set[Labels] = field(default_factory=set)  # cells that get no more trials, as a stored one differs
    verify: bool = False  # whether one trial of each optimizer is made again at the end
    folder: Path | None = None  # of the results

    def trials(self) -> Iterator[Trial]:
        """Yield every trial, finished or not, in the order in which they are to be made."""
        plan = self.study.plan(self.seeds)
        return plan if self.shard is None else islice(plan, self.shard.number - 1, None, self.shard.of)

    def missing(self) -> Iterator[Trial]:
        """Yield the trials that are not finished at the moment they are reached."""
        left = (trial for trial in self.trials() if trial.key[:2] not in self.doubtful)
        return (trial for trial in left if trial.key not in self.finished)

    def counts(self) -> dict[tuple[str, str], tuple[int, int]]:
        """Return for each cell (problem, optimizer) the number of trials, and of those finished."""
        counts: dict[tuple[str, str], tuple[int, int]] = {}
        for trial in self.trials():
            planned, done = counts.get(trial.key[:2], (0, 0))
            counts[trial.key[:2]] = planned + 1, done + (trial.key in self.finished)
        return counts

    def seconds(self) -> float | None:
        """Estimate the seconds on one processor that the missing trials will take; None where no trial is stored.

        A cell without stored trials counts as the mean of its optimizer's other trials, or else of all trials.
        """
        groups: dict[tuple[str, ...], list[CellCounts]] = defaultdict(list)
        for cell in self.cells:
            if cell.done:
                for group in ((cell.problem, cell.optimizer), (cell.optimizer,), ()):
                    groups[group].append(cell)
        if not groups:
            return None
        means = {
            group: sum(cell.wall_s for cell in cells) / sum(cell.done for cell in cells)
            for group, cells in groups.items()
        }
        return self.total(
            lambda problem, optimizer: means.get((problem, optimizer), means.get((optimizer,), means[()]))
        )

    def total(self, seconds: Callable[[str, str], float]) -> float:
        """Return the seconds of all trials to be made, of which each takes ``seconds(problem, optimizer)``.

        The one of each optimizer that is made again is one of those that take least.
        """
        total, least = 0.0, dict[str, float]()
        for (problem, optimizer), (planned, finished) in self.counts().items():
            if planned > finished:
                took = seconds(problem, optimizer)
                total += (planned - finished) * took
                least[optimizer] = min(took, least.get(optimizer, took))
        return total + (sum(least.values()) if self.verify else 0.0)


class Listener:
    """What a run calls as it goes on; a subclass overrides what it wants to hear of."""

    def plan(self, plan: Plan) -> None:
        """Hear the plan, once, before the first trial."""

    def trial(self, trial: Trial, row: Row) -> None:
        """Hear of a finished trial, with its row."""
