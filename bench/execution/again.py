"""Make one trial of each optimizer again at the end of a run, and compare trials made again with stored ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from bench.columns import Row, named
from bench.execution.local import Answer
from bench.execution.plan import EXPENSIVE
from bench.helpers.text import count
from bench.objective import OUT_OF_TIME
from bench.storage.folder import AT_ENDS, VERIFICATION, Folder
from bench.storage.rows import disagreement
from bench.storage.store import Store
from bench.study import Study
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
        chosen = [replace(trial, again=True) for _, trial in self._chosen.values()]
        if not chosen:
            return []
        made, different = 0, []
        for trial, row, _ in answers(lambda: chosen):
            row.pop("inputs", None)
            if row["status"] != "timeout" and not by_the_clock(row, self._study):
                made += 1
                if what := difference(folder.store, trial, row):
                    different.append(difference_line(trial, what))
        if made:
            trials, lines = folder.repeated()
            trials, lines = trials + made, [*dict.fromkeys([*lines, *different])]
            sentence = (
                f"{trials - len(lines):,} of {count(trials, 'trial')} that runs made again at their ends, one of each "
                f"optimizer in a fresh process, {'is' if trials == 1 else 'are'} the same bit by bit"
            )
            part = {"trials": trials, "sentence": sentence, "different": lines}
            folder.note(VERIFICATION, folder.noted(VERIFICATION) | {AT_ENDS: part})
        return different


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


def difference_line(trial: Trial, what: str) -> str:
    """Return the line on a trial that differs."""
    return f"different: {trial.optimizer} on {trial.problem}, trial {trial.number}: {what}"
