"""The contract of a pool, which makes trials somewhere, and what all pools have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

from bench.execution.supervisor import Task
from bench.trial import Row, Trial

OnBegin = Callable[[int, Trial], None]
Answer = tuple[Trial, Row, str]  # with the record (JSON) of the machine that made it


def ignore(job: int, trial: Trial) -> None:
    """Ignore that a trial begins."""


class WorkerDiedError(RuntimeError):
    """Workers were killed several times in a row, or their scheduler was lost; every finished trial is kept."""


class Pool(Protocol):
    """Makes ``jobs`` trials at a time."""

    jobs: int

    def answers(
        self, task: Task, machine: str, missing: Callable[[], Iterable[Trial]], on_begin: OnBegin = ignore
    ) -> Iterator[Answer]:
        """Yield each missing trial with its row and its machine's record as they finish, in any order.

        Args:
            task: what all trials have in common.
            machine: the record (JSON) of this machine.
            missing: returns the trials that are not finished at the moment they are reached.
            on_begin: called with the number of a job and the trial that it begins, where that is known.

        Raises:
            WorkerDiedError: when workers are killed several times in a row.
            BenchError: for workers that cannot be used.
        """
        ...
