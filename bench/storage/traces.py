"""The anytime traces of a study, held as the bytes that the store holds: a study may have hundreds of thousands."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from operator import itemgetter
from typing import Any

from bench.objective import IMPROVEMENT, Trace

Key = tuple[str, str, int]
"""Problem label, optimizer label and number of a trial."""


@dataclass
class CellTraces:
    """The packed traces of one cell, end to end, with the numbers of their trials, increasing."""

    trials: list[int] = field(default_factory=list)
    ends: list[int] = field(default_factory=lambda: [0])  # of each trace, after the beginning of the first
    packed: bytes = b""

    def __iter__(self) -> Iterator[Trace]:
        whole = memoryview(self.packed)
        return (Trace.unpacked(whole[start:end]) for start, end in pairwise(self.ends))

    def find(self, trial: int) -> Trace | None:
        """Return the trace of a trial, None where it has none."""
        place = bisect_left(self.trials, trial)
        if place == len(self.trials) or self.trials[place] != trial:
            return None
        return Trace.unpacked(memoryview(self.packed)[self.ends[place] : self.ends[place + 1]])


class Traces(Mapping[Key, Trace]):
    """The traces of trials by (problem, optimizer, trial), cell by cell in the order of the store.

    A trace is unpacked when it is asked for, as objects for all would take several times their bytes.
    """

    def __init__(self, cells: Mapping[tuple[str, str], CellTraces]) -> None:
        self.cells = cells

    @classmethod
    def read(cls, rows: Iterable[Mapping[str, Any]]) -> Traces:
        """Gather the traces of a store's rows, which come cell by cell and by trial; a row without one is left out.

        Raises:
            ValueError: when a trace is damaged.
        """
        cells: dict[tuple[str, str], CellTraces] = {}
        for (problem, optimizer), cell_rows in groupby(rows, itemgetter("problem", "optimizer")):
            cell, packed = CellTraces(), []
            for row in cell_rows:
                if (trace := row["trace"]) is not None:
                    if not isinstance(trace, bytes) or len(trace) % IMPROVEMENT:
                        raise ValueError(f"the trace of trial {row['trial']} is damaged")
                    cell.trials.append(row["trial"])
                    cell.ends.append(cell.ends[-1] + len(trace))
                    packed.append(trace)
            cell.packed = b"".join(packed)
            cells[problem, optimizer] = cell
        return cls(cells)

    def __getitem__(self, key: Key) -> Trace:
        problem, optimizer, trial = key
        cell = self.cells.get((problem, optimizer))
        trace = cell.find(trial) if cell else None
        if trace is None:
            raise KeyError(key)
        return trace

    def __iter__(self) -> Iterator[Key]:
        for (problem, optimizer), cell in self.cells.items():
            for trial in cell.trials:
                yield problem, optimizer, trial

    def __len__(self) -> int:
        return sum(len(cell.trials) for cell in self.cells.values())
