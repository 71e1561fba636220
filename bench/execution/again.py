"""Make stored trials again and compare them: before a cell gets more, and one of each optimizer at the end of a run."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from bench.columns import Row, named
from bench.execution.journal import place
from bench.execution.local import Answer
from bench.execution.plan import EXPENSIVE, Plan
from bench.objective import OUT_OF_TIME
from bench.plugins.inputs import conflicts
from bench.storage.cells import split
from bench.storage.folder import Folder, difference_line
from bench.storage.rows import disagreement
from bench.storage.store import Store
from bench.study import Study
from bench.study.cell import Labels
from bench.trial import Trial


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
        rank = -after, row.get("wall_s", 0.0)
        if row["status"] == "ok" and row["objective_s"] * self._study.parallel >= EXPENSIVE * row["nfev"]:
            self.expensive.add(trial.optimizer)
            return
        best, _ = self._chosen.get(trial.optimizer, (rank, trial))
        if row["status"] == "ok" and not by_the_clock(row, self._study) and rank <= best:
            self._chosen[trial.optimizer] = rank, trial

    def make(self, folder: Folder, answers: Callable[[Callable[[], Iterable[Trial]]], Iterator[Answer]]) -> list[str]:
        """Make the chosen trials again, note the outcome in the folder, and return a line for each that differs.

        One that takes longer than the limits of time, on a machine that may be busier now, is not counted.
        """
        trials = [trial for _, trial in self._chosen.values()]
        self.expensive |= {trial.optimizer for trial in trials if place(folder.path, trial).exists()}
        chosen = [replace(trial, again=True) for trial in trials if not place(folder.path, trial).exists()]
        if not chosen:
            return []
        compared = _compared(chosen, folder, self._study, answers)
        folder.note_repeated(compared)
        return [difference_line(trial, what) for trial, what in compared.items() if what]


def doubtful(
    plan: Plan, folder: Folder, answers: Callable[[Callable[[], Iterable[Trial]]], Iterator[Answer]]
) -> dict[Trial, str]:
    """Make a stored trial of each cell again that is to get more; return those that differ, and how.

    Something that no process was seen to read is then another: nothing may be added to their cells. The trials are
    those that took least time; none is made again where evaluations are expensive.
    """
    growing = {trial.key[:2] for trial in plan.missing()}
    columns = ("problem", "optimizer", "trial", "seed", "status", "stop", "failures", "wall_s", "objective_s", "nfev")
    least: dict[Labels, tuple[float, Trial]] = {}
    for row in folder.store.rows("status = 'ok' AND seed IS NOT NULL", columns=columns) if growing else ():
        labels = row["problem"], row["optimizer"]
        dear = row["objective_s"] * plan.study.parallel >= EXPENSIVE * row["nfev"]
        if labels in growing and not dear and not by_the_clock(row, plan.study):
            found = row["wall_s"], Trial(*labels, row["trial"], row["seed"], again=True)
            if place(folder.path, found[1]).exists():  # its evaluations are slow, though a journal may have answered
                continue
            least[labels] = min(least.get(labels, found), found, key=lambda each: each[0])
    compared = _compared([trial for _, trial in least.values()], folder, plan.study, answers)
    return {trial: what for trial, what in compared.items() if what}


def _compared(
    chosen: Sequence[Trial],
    folder: Folder,
    study: Study,
    answers: Callable[[Callable[[], Iterable[Trial]]], Iterator[Answer]],
) -> dict[Trial, str]:
    """Make trials again; return how each differs, "" where it does not.

    One that takes longer than the limits of time, on a machine that may be busier now, is left out, and so is one whose
    inputs were edited meanwhile.
    """
    compared = {}
    held = folder.store.held()
    cells = held.by_labels
    for trial, row, _ in answers(lambda: chosen) if chosen else ():
        made_from, *_ = (row.pop(key, None) for key in ("inputs", "after", "unasked", "journal"))
        theirs = split(json.loads(made_from or "{}"))
        if any(conflicts(*pair) for pair in zip(held.made_from(cells[trial.key[:2]]), theirs, strict=True)):
            continue
        if row["status"] != "timeout" and not by_the_clock(row, study):
            compared[trial] = difference(folder.store, trial, row)
    return compared


def by_the_clock(row: Mapping[str, Any], study: Study) -> bool:
    """Return whether a limit of time may have decided a trial: its own, or that of an evaluation, where any failed."""
    failed = row["status"] == "failed" or row.get("failures")
    return row.get("stop") == OUT_OF_TIME or (study.evaluation_timeout is not None and bool(failed))


def difference(store: Store, trial: Trial, row: Row) -> str:
    """Return how a trial made again differs from the stored one, "" where it does not."""
    before, again = store.find(*trial.key), row | trial.columns
    if before is None:
        return "it is no longer stored"
    if row["status"] != "ok":
        return str(row["error"]).partition("\n")[0]
    name = disagreement(before, again)
    if name in ("", "trace"):
        return name and "another course, the same end"
    return f"{name} was {named(before, name)} and is {named(again, name)}"
