"""Make stored trials again under other conditions and compare them bit by bit."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from os import PathLike

from joblib import cpu_count

from bench.contract.numbers import require_whole
from bench.execution.again import by_the_clock, made_again
from bench.execution.job import Task
from bench.execution.local import Answer, Local, Missing
from bench.execution.runner import resolved
from bench.execution.supervisor import Loaded
from bench.helpers.console import OnStep
from bench.helpers.errors import BenchError
from bench.sandbox.server import FORKS
from bench.storage import provenance
from bench.storage.folder import AT_ENDS, VERIFICATION, Folder, difference_line
from bench.study import Study
from bench.trial.trial import Trial

HASH_SEED = 4242  # other than the 0 of a run's processes


@dataclass(frozen=True)
class Verification:
    """The outcome of making ``trials`` trials of ``cells`` cells (problem, optimizer) again with ``jobs`` workers."""

    cells: int
    trials: int
    jobs: int
    different: dict[Trial, str] = field(default_factory=dict)  # the trials that differ, each with the difference
    notes: tuple[str, ...] = ()  # differences between this environment and the one that made the trials
    stored: str = ""  # what the digests of all stored trials say

    @property
    def sentence(self) -> str:
        """The outcome in one sentence."""
        same = self.trials - len(self.different)
        workers = f"{self.jobs} worker{'s' if self.jobs > 1 else ''}"
        same_bits = f"{same:,} of {self.trials:,} trials of {self.cells:,} cells are the same bit by bit"
        elsewhere = f", though in another environment ({'; '.join(self.notes)})" if self.notes else ""
        apart = ", the problem in another process than the optimizer" if FORKS else ""
        order = "one of each optimizer made both first and last"
        return f"{same_bits} with {workers} and another PYTHONHASHSEED, {order}{apart}{elsewhere}"

    def lines(self) -> Iterator[str]:
        """Yield a line for every trial that differs."""
        for trial, what in self.different.items():
            yield difference_line(trial, what)


def verify(
    path: str | PathLike[str],
    *,
    trials: int = 2,
    n_jobs: int | None = None,
    untrusted: bool = False,
    on_progress: OnStep | None = None,
) -> Verification:
    """Make some finished trials of every cell again and note in the folder whether they are identical.

    One trial of each optimizer is made first and, once more, after all others, so that an optimizer that learns from
    trial to trial is found out. Where processes fork, problem, budget and trace are kept in another process than the
    optimizer: one that spends more evaluations than it is given, or gets values by another way than the objective, is
    found out, too.

    Trials that a limit of time has ended (``time`` of a study) cannot be repeated, and are left out. All stored trials
    are compared with their digests; a store with a damaged one is refused.

    Args:
        path: the folder that ``bench.run`` wrote.
        trials: the number of trials of each cell, chosen at random.
        n_jobs: trials made at a time; None for a number other than the run's.
        untrusted: run all plug-ins in a sandbox of bubblewrap, with limits (Linux).
        on_progress: called with a title, the trials made and the total.

    Raises:
        BenchError: when the folder holds no finished trial, or its data or code changed.
    """
    folder = Folder(path)
    study = folder.study()
    store = folder.require_sound()
    chosen = _chosen(folder, study, trials)
    first = {trial.optimizer: trial for trial in reversed(chosen)}
    planned = [*first.values(), *(trial for trial in chosen if trial not in first.values()), *first.values()]
    cores, noted = int(cpu_count()), [record.get("jobs") for record in folder.environments()]
    n_jobs = n_jobs or (cores + 1 if noted[-1:] == [cores] else cores)  # other than the last run's, and no core idle
    late: dict[Trial, str] = {}
    with Local(n_jobs) as pool:

        def load(task: Task) -> Loaded:
            return pool.load(replace(task, hash_seed=HASH_SEED, apart=FORKS))

        found = resolved(study, path, untrusted=untrusted, load=load).loaded
        folder.require_unchanged(study, found.dimensions, found.present)

        def make(missing: Missing) -> Iterator[Answer]:
            answers = pool.answers(None, missing)
            for made, (trial, row, machine) in enumerate(answers, start=1):
                if row["status"] == "timeout":
                    late[trial] = str(row["error"])
                if on_progress is not None:
                    on_progress(f"{trial.optimizer} on {trial.problem}", made, len(planned))
                yield trial, row, machine

        compared = made_again(planned, folder, study, make)
    different = late | {trial: what for trial, what in compared.items() if what}
    cells = len({trial.key[:2] for trial in chosen})
    notes = tuple(folder.differences(provenance.machine()))
    outcome = Verification(cells, len(chosen), pool.jobs, different, notes, store.sentence)
    about = {"sentence": outcome.sentence, "different": [*outcome.lines()]}
    kept = {key: value for key, value in folder.noted(VERIFICATION).items() if key == AT_ENDS}
    with suppress(BenchError):  # of a folder that cannot be written to, the verdict is what is returned
        folder.note(VERIFICATION, kept | {"verified": provenance.now(), "cells": cells, "trials": len(chosen)} | about)
    return outcome


def _chosen(folder: Folder, study: Study, trials: int) -> list[Trial]:
    """Return up to ``trials`` finished trials of each cell, chosen at random."""
    require_whole("the number of trials to verify", trials, 1)
    cells: dict[tuple[str, str], list[Trial]] = {}
    columns = ("problem", "optimizer", "trial", "seed", "status", "stop", "failures")
    for row in folder.store.rows("status = 'ok'", columns=columns):
        if by_the_clock(row, study):
            continue
        cell = cells.setdefault((row["problem"], row["optimizer"]), [])
        again = not FORKS  # else the problem is kept apart, and nothing is answered from a journal
        cell.append(Trial(row["problem"], row["optimizer"], row["trial"], row["seed"], again))
    if not cells:
        limits = [limit for limit in (study.rules.time, study.rules.evaluation_timeout) if limit is not None]
        but = ", but of those that a limit of time may have decided" if limits else ""
        raise BenchError(f"{folder.path} holds no finished trial to verify{but}")
    choice = random.Random(study.seed)
    return [trial for cell in cells.values() for trial in choice.sample(cell, min(trials, len(cell)))]
