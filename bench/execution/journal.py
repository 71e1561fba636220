"""The journal of a trial: its slow evaluations, from which it is answered when it is made again after an interruption.

A trial's points depend on its seed and on the values before them alone. So one that was interrupted is made again from
the beginning, and as long as it asks for the same points, bit by bit, their values come from the journal. The first
other point ends that, and the journal goes on from there.

A journal is a file of JSON lines: first what was evaluated, then a line for each point, as soon as it is known.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.atomic import replacing
from bench.helpers.console import duration
from bench.helpers.text import short_hash
from bench.plugins.inputs import Inputs, Present
from bench.storage.under_way import left
from bench.trial.trial import Trial

FOLDER = "journal"
SLOW = 0.1  # seconds of an evaluation from which on it is worth a line and its way to the disk
_FROM_OUTSIDE = re.compile(r"\bsignal (1|2|9|15)\b|SIG(HUP|INT|KILL|TERM)")  # the end of a run, not of an evaluation


class Journal:
    """The evaluations of a trial, by their numbers from 0.

    Args:
        folder: of results.
        key: which trial it is: the labels of problem and optimizer, its number and its seed.
        about: what was evaluated; evaluations of anything else are forgotten.
        inputs: returns what the problem was seen to read so far; where any of it changed, they are forgotten, too.
        limit: seconds that an evaluation may take; points that failed are evaluated again under another limit.
        always: whether also fast evaluations are noted.
    """

    def __init__(
        self,
        folder: Path,
        key: dict[str, Any],
        about: dict[str, Any],
        inputs: Callable[[], Inputs] = dict,
        limit: float | None = None,
        always: bool = False,
    ) -> None:
        self.path = place(folder, Trial(key["problem"], key["optimizer"], key["trial"], key["seed"]))
        self._head = key | {"about": json.loads(json.dumps(about, default=str)), "limit": limit}
        self._inputs, self._noted, self._file = inputs, Inputs(), -1
        self._lines: dict[int, dict[str, Any]] = {}  # by the numbers of the evaluations
        self._count = self.replayed = self.dropped = 0
        head, records = read(self.path)
        recorded = {name: (state, known) for name, (state, known) in head.get("inputs", {}).items()}
        if head.get("about") == self._head["about"] and not Present().changed(recorded):
            self._lines = {each["n"]: each for each in records if "error" not in each or head.get("limit") == limit}
        self.slow: bool | None = True if always or self._lines else None  # None until an evaluation was measured

    def answers(self, x: Floats) -> dict[int, dict[str, Any]]:
        """Return the lines of the (n, d) points that are evaluated next, by row; another point ends the journal."""
        found = {}
        for row, point in enumerate(x):
            line = self._lines.get(self._count + row)
            if line is not None and np.array(line["x"], np.float64).tobytes() != point.tobytes():
                after = [number for number in self._lines if number >= self._count + row]
                self.dropped += len(after)
                for number in after:
                    del self._lines[number]
                self.close()
                break
            if line is not None:
                found[row] = line
        return found

    def takes(self, reason: str, seconds: float, goes_on: bool) -> bool:
        """Return whether an evaluation is to be noted: a slow one, and of one that failed what it would be again."""
        self.slow = seconds >= SLOW if self.slow is None else self.slow
        return self.slow and not (reason and (_FROM_OUTSIDE.search(reason) or not goes_on))

    def add(self, row: int, x: Floats, value: float, violations: Floats, seconds: float, error: str) -> None:
        """Add the line of an evaluation, by its row in the call."""
        line = {"n": self._count + row, "x": x.tolist(), "f": value, "g": violations.tolist(), "s": round(seconds, 3)}
        self._write(line | ({"error": error} if error else {}))

    def end(self, evaluated: int, replayed: int) -> None:
        """Have what a call of so many evaluations added reach the disk, with what the problem has read by now."""
        self._count += evaluated
        self.replayed += replayed
        if self._file >= 0:
            if (inputs := self._inputs()) != self._noted:
                self._write({"inputs": inputs})
                self._noted = inputs
            os.fsync(self._file)

    def close(self) -> None:
        """Close its file."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def _write(self, line: dict[str, Any]) -> None:
        if self._file < 0:  # it begins anew with the lines that count
            self.path.parent.mkdir(exist_ok=True)
            self._noted = self._inputs()
            with replacing(self.path) as beside:
                beside.write_text("".join(map(_line, (self._head | {"inputs": self._noted}, *self._lines.values()))))
            self._file = os.open(self.path, os.O_WRONLY | os.O_APPEND)
        if "n" in line:
            self._lines[line["n"]] = line
        os.write(self._file, _line(line).encode())


def _line(content: dict[str, Any]) -> str:
    return json.dumps(content) + "\n"


def place(folder: Path, trial: Trial) -> Path:
    """Return the file of a trial's journal in a folder of results, which is there where its evaluations are slow."""
    return folder / FOLDER / f"{short_hash(json.dumps([*trial.key, trial.seed]))}.jsonl"


def read(path: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return the first line of a journal, with what was noted as read last, and its evaluations; a cut line is none."""
    head, records = dict[str, Any](), list[dict[str, Any]]()
    with suppress(OSError):
        for text in path.read_text(encoding="utf-8", errors="replace").splitlines():
            with suppress(ValueError):
                line = json.loads(text)
                if "n" in line:
                    records.append(line)
                else:
                    head |= line
    return head, records


def journals(folder: Path) -> Iterator[tuple[dict[str, Any], list[dict[str, Any]]]]:
    """Yield the journals of a folder of results, each with its evaluations."""
    for path in sorted((folder / FOLDER).glob("*.jsonl")):
        yield read(path)


def best(records: list[dict[str, Any]]) -> float:
    """Return the lowest value of a feasible point, +inf without any."""
    return min((each["f"] for each in records if all(excess <= 0 for excess in each["g"])), default=inf)


def under_way(folder: Path) -> Iterator[tuple[dict[str, Any], list[dict[str, Any]]]]:
    """Yield the journals of the trials under way in a folder, each with its evaluations."""
    begun = [tuple(trial) for trial in (left(folder) or {"trials": []})["trials"]]
    for head, records in journals(folder) if begun else ():
        if records and (head.get("problem"), head.get("optimizer"), str(head.get("trial"))) in begun:
            yield head, records


def under_way_lines(folder: Path, parallel: int) -> Iterator[str]:
    """Yield a line for each trial under way: its evaluations, its best value and the time left."""
    for head, records in under_way(folder):
        missing = head["budget"] - len(records)
        seconds = sum(each["s"] for each in records) / len(records) * missing / parallel
        yield (
            f"  {head['optimizer']} on {head['problem']}, trial {head['trial']}: {len(records):,} of "
            f"{head['budget']:,} evaluations, best {best(records):.6g}, about {duration(seconds)} left"
        )
