"""Make stored trials again and compare them: before a cell gets more, and one of each optimizer at the end of a run."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from bench.contract.objective import OUT_OF_TIME
from bench.execution.journal import place
from bench.execution.local import Answer, Missing
from bench.execution.plan import EXPENSIVE, Plan
from bench.storage.cells import split
from bench.storage.folder import Folder, difference_line
from bench.storage.rows import disagreement
from bench.study import Study
from bench.study.cell import Labels
from bench.trial.columns import Row, named
from bench.trial.trial import Trial

Make = Callable[[Missing], Iterator[Answer]]
"""Makes trials: the answers of a pool."""


class Repetition:
    """Chooses a trial of each optimizer while they are made, and makes these again in fresh processes.

    An optimizer that keeps something from trial to trial gives other results there. So a trial is chosen that came
    after others in its process, if possible of its own problem, and of these the one that took least time. None is
    made again of an optimizer whose trials all have expensive evaluations.

    Args:
        study: whose trials they are.

    Attributes:
        expensive: the optimizers whose trials had them.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self.expensive: set[str] = set()
        self._chosen: dict[str, tuple[tuple[int, float], Trial]] = {}

    def consider(self, trial: Trial, row: Row, after: int) -> None:
        """Take note of a trial, and of how many kinds of trials came before it in its process."""
        if row["status"] == "ok" and is_expensive(row, self._study):
            self.expensive.add(trial.optimizer)
        elif row["status"] == "ok" and not by_the_clock(row, self._study):
            rank = -after, row["wall_s"]
            best, _ = self._chosen.get(trial.optimizer, (rank, trial))
            if rank <= best:
                self._chosen[trial.optimizer] = rank, trial

    def make(self, folder: Folder, make: Make) -> list[str]:
        """Make the chosen trials again, note the outcome in the folder, and return a line for each that differs."""
        chosen = []
        for _, trial in self._chosen.values():
            if place(folder.path, trial).exists():  # its evaluations are slow, though a journal may have answered
                self.expensive.add(trial.optimizer)
            else:
                chosen.append(replace(trial, again=True))
        compared = made_again(chosen, folder, self._study, make)
        folder.note_repeated(compared)
        return [difference_line(trial, what) for trial, what in compared.items() if what]


def doubtful(plan: Plan, folder: Folder, make: Make) -> dict[Trial, str]:
    """Make a stored trial of each cell again that is to get more; return those that differ, and how.

    Something that no process was seen to read is then another: nothing may be added to their cells. The trials are
    those that took least time; none is made again where evaluations are expensive.
    """
    growing = {trial.key[:2] for trial in plan.missing()}
    columns = ("problem", "optimizer", "trial", "seed", "status", "stop", "failures", "wall_s", "objective_s", "nfev")
    least: dict[Labels, tuple[float, Trial]] = {}
    for row in folder.store.rows("status = 'ok' AND seed IS NOT NULL", columns=columns) if growing else ():
        labels = row["problem"], row["optimizer"]
        if labels in growing and not is_expensive(row, plan.study) and not by_the_clock(row, plan.study):
            found = row["wall_s"], Trial(*labels, row["trial"], row["seed"], again=True)
            if not place(folder.path, found[1]).exists():
                least[labels] = min(least.get(labels, found), found, key=lambda each: each[0])
    compared = made_again([trial for _, trial in least.values()], folder, plan.study, make)
    return {trial: what for trial, what in compared.items() if what}


def made_again(trials: Iterable[Trial], folder: Folder, study: Study, make: Make) -> dict[Trial, str]:
    """Make stored trials again; return how each differs, "" where it does not, and the first difference where it does.

    One that takes longer than the limits of time, on a machine that may be busier now, is left out, and so is one whose
    inputs were edited meanwhile.
    """
    compared: dict[Trial, str] = {}
    held = folder.store.held()
    cells = held.by_labels
    for trial, row, _ in make(lambda: trials):
        theirs = split(json.loads(row.pop("beside", {}).get("inputs") or "{}"))
        edited = held.conflicts(cells[trial.key[:2]], theirs)
        if not (edited or row["status"] == "timeout" or by_the_clock(row, study)):
            compared[trial] = compared.get(trial) or _difference(folder, trial, row)
    return compared


def is_expensive(row: Row, study: Study) -> bool:
    """Return whether an evaluation of a trial took so long that none is made that nobody asked for."""
    return bool(row["objective_s"] * study.rules.parallel >= EXPENSIVE * row["nfev"])


def by_the_clock(row: Row, study: Study) -> bool:
    """Return whether a limit of time may have decided a trial: its own, or that of an evaluation, where any failed."""
    failed = row["status"] == "failed" or row.get("failures")
    return row.get("stop") == OUT_OF_TIME or (study.rules.evaluation_timeout is not None and bool(failed))


def _difference(folder: Folder, trial: Trial, row: Row) -> str:
    """Return how a trial made again differs from the stored one, "" where it does not."""
    before, again = folder.store.find(*trial.key), row | trial.columns
    if before is None:
        return "it is no longer stored"
    if row["status"] != "ok":
        return str(row["error"]).partition("\n")[0]
    name = disagreement(before, again)
    if name in ("", "trace"):
        return name and "another course, the same end"
    return f"{name} was {named(before, name)} and is {named(again, name)}"
