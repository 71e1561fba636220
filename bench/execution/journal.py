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
from time import perf_counter
from typing import Any

import numpy as np

from bench.errors import PointError
from bench.helpers.console import duration
from bench.helpers.text import short_hash
from bench.objective import as_values
from bench.plugins.inputs import Inputs, Present
from bench.problem import Problem
from bench.sandbox.messages import describe_error
from bench.storage.under_way import left
from bench.trial import Trial
from bench.typing import Floats

FOLDER = "journal"
SLOW = 0.1  # seconds of an evaluation from which on it is worth a line and its way to the disk
_FROM_OUTSIDE = re.compile(r"\bsignal (1|2|9|15)\b|SIG(HUP|INT|KILL|TERM)")  # the end of a run, not of an evaluation

Done = Callable[[int, float, str, float], None]
"""Is called for each point evaluated: its row, its value, why it failed ("" where it did not), and the seconds."""


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
        self._records: dict[int, dict[str, Any]] = {}
        self.replayed = self.dropped = 0
        head, records = read(self.path)
        recorded = {name: (state, known) for name, (state, known) in head.get("inputs", {}).items()}
        if head.get("about") == self._head["about"] and not Present().changed(recorded):
            kept = [each for each in records if "error" not in each or head.get("limit") == limit]
            self._records = {each["n"]: each for each in kept}
        self.slow: bool | None = True if always or self._records else None  # None until an evaluation was measured

    def answer(self, number: int, point: Floats) -> dict[str, Any] | None:
        """Return the line of an evaluation, None where it is not there; another point ends the journal here."""
        record = self._records.get(number)
        if record is not None and np.array(record["x"], np.float64).tobytes() != point.tobytes():
            self.dropped += sum(each >= number for each in self._records)
            self._records = {each: line for each, line in self._records.items() if each < number}
            self.close()
            return None
        return record

    def add(self, record: dict[str, Any]) -> None:
        """Add the line of an evaluation."""
        if self._file < 0:
            self.path.parent.mkdir(exist_ok=True)
            beside = self.path.with_suffix(".new")
            self._noted = self._inputs()
            lines = [self._head | {"inputs": self._noted}, *self._records.values()]
            beside.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
            beside.replace(self.path)
            self._file = os.open(self.path, os.O_WRONLY | os.O_APPEND)
        self._records[record["n"]] = record
        os.write(self._file, json.dumps(record).encode() + b"\n")

    def sync(self) -> None:
        """Have what was added reach the disk, with what the problem was seen to read by now."""
        if self._file >= 0:
            if (inputs := self._inputs()) != self._noted:
                self._noted = inputs
                os.write(self._file, json.dumps({"inputs": inputs}).encode() + b"\n")
            os.fsync(self._file)

    def close(self) -> None:
        """Close its file."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


class Recorded:
    """The evaluations of a problem in a trial, each noted in its journal or answered from it.

    Args:
        problem: without noise.
        journal: of the trial.
        beside: evaluates the points of a call by processes of the problem; None where this process does.
        goes_on: whether the other points of a batch are evaluated where one has failed.
    """

    def __init__(
        self, problem: Problem, journal: Journal, beside: Callable[[Floats, Done], Floats] | None, goes_on: bool
    ) -> None:
        self._problem, self._journal, self._beside, self._goes_on = problem, journal, beside, goes_on
        self._count = 0  # evaluations
        self._violations: dict[bytes, Floats] = problem.found if problem.joint else {}

    def close(self) -> None:
        """Close the journal."""
        self._journal.close()

    def values(self, x: Floats) -> Floats:
        """Return the (n,) values of the (n, d) points; raises PointError where any fails."""
        if self._journal.slow is False:
            return self._problem.evaluate(x) if self._beside is None else self._beside(x, lambda *_: None)
        n, first = len(x), self._count
        together = self._beside is None and not self._problem.by_point
        found = [self._journal.answer(first + row, x[row]) for row in range(n)]
        if together and None in found:  # a value may depend on the batch in its last bits
            found = [None] * n
        values, failed = np.full(n, inf), dict[int, str]()

        def done(row: int, value: float, reason: str, seconds: float, *, noted: dict[str, Any] | None = None) -> None:
            if reason:
                failed[row] = reason
            else:
                values[row] = value
            if self._journal.slow is None:
                self._journal.slow = seconds >= SLOW
            key = x[row].tobytes()
            if noted is not None:
                self._violations[key] = np.array(noted["g"], np.float64)
            elif self._journal.slow:
                if key not in self._violations:
                    broken = np.full(self._problem.joint, inf) if reason else self._problem.violations(x[row : row + 1])
                    self._violations[key] = np.empty(0) if broken is None else np.ravel(broken)
                line = {"n": first + row, "x": x[row].tolist(), "f": value, "g": self._violations[key].tolist()}
                if not reason or (self._goes_on and not _FROM_OUTSIDE.search(reason)):
                    self._journal.add(line | {"s": round(seconds, 3)} | ({"error": reason} if reason else {}))

        for row, record in enumerate(found):
            if record is not None:
                self._journal.replayed += 1
                done(row, record["f"], record.get("error", ""), record["s"], noted=record)
        left = [row for row in range(n) if found[row] is None]
        if left and self._beside is not None:
            with suppress(PointError):  # its reasons are known
                self._beside(x[left], lambda each, *answer: done(left[each], *answer))
        elif left and together:
            began = perf_counter()
            answers = as_values(self._problem, self._problem.evaluate(x.copy()), n)
            seconds = (perf_counter() - began) / n
            for row in left:
                done(row, answers[row], "", seconds)
        else:
            for row in left:
                done(row, *self._alone(x[row : row + 1]))
        self._count += n
        self._journal.sync()
        if failed:
            raise PointError(failed[min(failed)], values.tolist(), len(failed))
        return values

    def violations(self, x: Floats) -> Floats | None:
        """Return the (n, m) violations of the (n, d) points, or None without constraints."""
        known = [self._violations.get(row.tobytes()) for row in x]
        if any(each is None or not len(each) for each in known):
            return self._problem.violations(x)
        return np.array(known)

    def _alone(self, x: Floats) -> tuple[float, str, float]:
        """Evaluate a (1, d) point; return its value, why it failed, and the seconds."""
        began = perf_counter()
        try:
            value, reason = float(as_values(self._problem, self._problem.evaluate(x.copy()), 1)[0]), ""
        except Exception as error:  # a plug-in may raise anything
            if not self._goes_on:
                raise
            value, reason = inf, describe_error(error)
        return value, reason, perf_counter() - began


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
