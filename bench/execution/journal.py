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
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from math import inf
from pathlib import Path

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.atomic import replacing
from bench.helpers.console import duration
from bench.helpers.parsing import JsonObject
from bench.helpers.text import short_hash
from bench.plugins.inputs import Inputs, Present
from bench.storage.under_way import left
from bench.trial.trial import Trial

FOLDER = "journal"
DROPPED = "{} in the journal were of no use: other points were asked for"
SLOW = 0.1  # seconds of an evaluation from which on it is worth a line and its way to the disk
Record = JsonObject
"""An evaluation: its value ``f``, its violations ``g`` or the ``error`` of one that failed, and its seconds ``s``."""

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
        key: JsonObject,
        about: JsonObject,
        inputs: Callable[[], Inputs] = dict,
        limit: float | None = None,
        always: bool = False,
    ) -> None:
        self.path = place(folder, Trial(key["problem"], key["optimizer"], key["trial"], key["seed"]))
        self._head: Record = json.loads(json.dumps(key | {"about": about, "limit": limit}, default=str))
        self._inputs, self._file = inputs, -1
        self._count = self.replayed = self.dropped = 0
        head, records = read(self.path)
        if head.get("about") != self._head["about"] or Present().changed(head["inputs"]):
            records = []
        same = head.get("limit") == limit
        self._lines = {each["n"]: each for each in records if same or "error" not in each}
        self.slow: bool | None = True if always or self._lines else None  # None until an evaluation was measured

    def answers(self, x: Floats) -> dict[int, Record]:
        """Return the records of the (n, d) points that are evaluated next, by row; another point ends the journal."""
        numbers = enumerate(range(self._count, self._count + len(x)))
        found = {row: self._lines[number] for row, number in numbers if number in self._lines}
        for row, line in found.items():
            if np.array(line["x"], np.float64).tobytes() != x[row].tobytes():
                kept = {number: each for number, each in self._lines.items() if number < self._count + row}
                self.dropped += len(self._lines) - len(kept)
                self._lines = kept
                self.close()
                return {before: each for before, each in found.items() if before < row}
        return found

    def add(self, row: int, point: Floats, record: Record) -> None:
        """Add an evaluation by its row in the call, where they are slow and no end of the run made it fail."""
        self.slow = record["s"] >= SLOW if self.slow is None else self.slow
        if not self.slow or _FROM_OUTSIDE.search(record.get("error", "")):
            return
        line = {"n": self._count + row, "x": point.tolist(), **record}
        self._lines[line["n"]] = line
        if self._file < 0:
            self._begin()
        else:
            os.write(self._file, _text(line))

    def end(self, evaluated: int, replayed: int) -> None:
        """Have what a call of so many evaluations added reach the disk, with what the problem has read by now."""
        self._count += evaluated
        self.replayed += replayed
        if self._file >= 0:
            if self._inputs() != self._head["inputs"]:
                self._begin()
            os.fsync(self._file)

    def _begin(self) -> None:
        """Write the file anew, with the lines that count."""
        self.close()
        self._head["inputs"] = self._inputs()
        self.path.parent.mkdir(exist_ok=True)
        with replacing(self.path) as beside:
            beside.write_bytes(b"".join(map(_text, (self._head, *self._lines.values()))))
        self._file = os.open(self.path, os.O_WRONLY | os.O_APPEND)

    def close(self) -> None:
        """Close its file."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def _text(line: Record) -> bytes:
    return f"{json.dumps(line)}\n".encode()


def place(folder: Path, trial: Trial) -> Path:
    """Return the file of a trial's journal in a folder of results, which is there where its evaluations are slow."""
    return folder / FOLDER / f"{short_hash(json.dumps([*trial.key, trial.seed]))}.jsonl"


def read(path: Path, trials: Collection[tuple[str, ...]] | None = None) -> tuple[Record, list[Record]]:
    """Return the head of a journal and its evaluations, none of another trial than these; lines that were cut are none.

    A trial is its problem, its optimizer and its number, as texts.
    """
    lines = list[Record]()
    with suppress(OSError), path.open(encoding="utf-8", errors="replace") as file:
        for text in file:
            with suppress(ValueError):
                lines.append(json.loads(text))
            head = lines[0] if lines else Record()
            trial = tuple(str(head.get(name)) for name in ("problem", "optimizer", "trial"))
            if "about" not in head or (trials is not None and trial not in trials):
                return {}, []
    return (lines[0], lines[1:]) if lines else ({}, [])


def journals(folder: Path, trials: Collection[tuple[str, ...]] | None = None) -> Iterator[tuple[Record, list[Record]]]:
    """Yield the journals of a folder of results, of all trials or of these: its head and its evaluations."""
    found = (read(path, trials) for path in sorted((folder / FOLDER).glob("*.jsonl")))
    return ((head, records) for head, records in found if records)


def under_way(folder: Path) -> Iterator[tuple[Record, list[Record]]]:
    """Yield the journals of the trials under way in a folder, likewise."""
    begun = left(folder)["trials"]
    return journals(folder, {tuple(trial) for trial in begun}) if begun else iter(())


def under_way_lines(folder: Path, parallel: int) -> Iterator[str]:
    """Yield a line for each trial under way: its evaluations, its best value and the time left."""
    for head, records in under_way(folder):
        missing = head["budget"] - len(records)
        seconds = sum(each["s"] for each in records) / len(records) * missing / parallel
        yield (
            f"  {head['optimizer']} on {head['problem']}, trial {head['trial']}: {len(records):,} of "
            f"{head['budget']:,} evaluations, best {best(records):.6g}, about {duration(seconds)} left"
        )


def best(records: list[Record]) -> float:
    """Return the lowest value of a feasible point, +inf without any."""
    return min((each["f"] for each in records if all(excess <= 0 for excess in each.get("g", []))), default=inf)
