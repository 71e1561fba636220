"""Distribute trials to workers through joblib, and collect their rows; common to all backends."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack
from typing import Any

from joblib import Parallel, delayed, parallel_config

from bench.execution.interrupts import signals_delayed
from bench.execution.supervisor import Task
from bench.trial import Row, Trial

DEATHS = 3  # of workers in a row, without a finished trial between them, before a run gives up

Answer = tuple[Trial, Row, str]


class WorkerDiedError(RuntimeError):
    """Workers were killed several times in a row, or their scheduler was lost; every finished trial is kept."""


class Pool:
    """Workers that make ``jobs`` trials at a time through one of joblib's backends; subclasses choose the backend."""

    work: Callable[[Task, Trial], Answer]  # called in a worker for each trial
    deaths: tuple[type[Exception], ...]  # raised by joblib when a worker ends during its work

    def __init__(self, jobs: int, window: int, backend: Any, **options: Any) -> None:
        self.jobs, self.window = jobs, window  # of the window's batches, dispatched together, all but ``jobs`` wait
        self._backend, self._options = backend, options

    def answers(self, task: Task, missing: Callable[[], Iterable[Trial]]) -> Iterator[Answer]:
        """Yield each trial with its row and its machine's record (JSON) as workers finish, in any order.

        A killed worker costs only time: the trials under way, still returned by ``missing``, are begun again.

        Raises:
            WorkerDiedError: when workers are killed several times in a row.
            BenchError: for workers that cannot be used.
        """
        deaths = 0
        while True:
            try:
                for answer in self._map(task, missing()):
                    deaths = 0
                    yield answer
                return
            except self.deaths as error:
                deaths += 1
                if deaths == DEATHS:
                    raise WorkerDiedError(
                        f"{DEATHS} worker processes in a row were killed before they had made a trial (is the machine "
                        "short of memory?); every finished trial is kept: run the same command again to continue"
                    ) from error

    def _map(self, task: Task, trials: Iterable[Trial]) -> Iterator[Answer]:
        """Yield answers until there are no more trials; short trials are dispatched in batches."""
        with parallel_config(n_jobs=self.jobs, backend=self._backend, **self._options), ExitStack() as ending:
            with signals_delayed():  # an interrupt while joblib dispatches would leave it in an undefined state
                self._start()
                parallel = Parallel(return_as="generator_unordered", batch_size="auto", pre_dispatch=self.window)
                answers = parallel(delayed(self.work)(task, trial) for trial in trials)
                ending.callback(_close, answers)
                self._settle()
            for answer in answers:  # no yield from: it would close answers, with a warning, before _close does  # noqa: UP028
                yield answer

    def _start(self) -> None:
        """Start what must run before the first trial."""

    def _settle(self) -> None:
        """Wait until dispatched trials can be cancelled."""


def _close(answers: Generator[Answer]) -> None:
    """Cancel the trials under way, without joblib's warning about them."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        answers.close()
