"""Read the rows of a store that are as they were written, and name those that are not."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import chain
from typing import Any

from bench.contract.objective import Trace
from bench.helpers.parsing import JsonObject
from bench.helpers.text import listed, printable
from bench.storage.cells import Cells, read, records_of
from bench.storage.committed import Committed
from bench.storage.rows import NAMES, TEXTS, VALUES, binding, decoded, digest
from bench.trial.columns import Row

NAMED = 3  # damaged trials that a sentence names
FETCHED = 500  # rows held as Python objects at a time: more would not fit in the processor's cache
LONGEST = 100  # characters of a label, which may be damaged too

READ = ("digest", "cell", "names", "trial", *VALUES)
"""The columns of the rows that are read to be compared with their digests."""

Key = tuple[str, str, int]
"""Problem label, optimizer label and number of a trial."""


class Traces(Mapping[Key, Trace]):
    """The anytime traces of trials by (problem, optimizer, trial), in the order of the store.

    They are held as the bytes of the store, as a study may have hundreds of thousands. A trace is unpacked when it is
    asked for.
    """

    def __init__(self, packed: Mapping[Key, bytes]) -> None:
        self.packed = packed

    def __getitem__(self, key: Key) -> Trace:
        return Trace.unpacked(self.packed[key])

    def __iter__(self) -> Iterator[Key]:
        return iter(self.packed)

    def __len__(self) -> int:
        return len(self.packed)


@dataclass
class StoreCheck:
    """The outcome of reading a store's rows: which of them are not as they were written.

    Nothing is read of a store that is not sound but its sound rows, by another folder (``--reuse``).
    """

    trials: int = 0  # rows read, damaged ones included
    damaged: list[str] = field(default_factory=list)  # trials, in words
    records: list[str] = field(default_factory=list)  # damaged ones, such as "environment 3"
    missing: int = 0  # rows that were committed and are not there
    lost: int = 0  # commits that the store lacks
    structure: str = ""  # SQLite's words on damage of the file's structure

    @property
    def sound(self) -> bool:
        """Whether no damage was found."""
        return not (self.damaged or self.records or self.missing or self.lost or self.structure)

    @property
    def sentence(self) -> str:
        """The outcome in one sentence, without a full stop."""
        parts = []
        if self.damaged:
            shown = listed(self.damaged, NAMED, between="; ")
            parts.append(f"{len(self.damaged):,} of {self.trials:,} trials are damaged ({shown})")
        if self.missing:
            parts.append(f"{self.missing:,} of {self.trials + self.missing:,} committed trials are missing")
        elif self.lost:
            parts.append(f"the last {self.lost:,} commits are lost")
        if self.records:
            parts.append(f"the record of {listed(self.records, NAMED)} is damaged")
        if self.structure:
            parts.append(f"the structure of the file is damaged ({self.structure})")
        if not parts:
            return f"all {self.trials:,} trials are as they were written"
        return ", and ".join(parts)


class Reader:
    """The rows of an open store at one moment, and which of them fit their digests.

    Attributes:
        names: the names of variables and of metrics as they are stored, JSON in UTF-8, by their number.

    Args:
        connection: to the store.
        noted: what was noted beside the store, before it was opened.
    """

    def __init__(self, connection: sqlite3.Connection, noted: Committed) -> None:
        self._connection, self._noted = connection, noted
        connection.text_factory = bytes  # damage may leave texts that are no UTF-8
        connection.execute("BEGIN")  # names, cells and rows of one moment, while a run adds to all
        self.names: dict[Any, tuple[bytes, ...]] = {
            number: (*texts,) for number, *texts in connection.execute("SELECT * FROM names")
        }

    @cached_property
    def cells(self) -> Cells:
        """The cells, and which of them are selected under which labels."""
        return read(self._connection)

    @cached_property
    def _bound(self) -> Callable[[Any, object], bytes | None]:
        """Return what the digests of a cell's rows with names of a number begin with; None where either is unknown."""
        cells, names = self.cells.all, self.names | {None: (None,) * len(NAMES)}

        @lru_cache(maxsize=FETCHED)  # rows come cell by cell
        def bound(cell: Any, number: object) -> bytes | None:
            return binding(cells[cell], names[number]) if cell in cells and number in names else None

        return bound

    @property
    def rows(self) -> int:
        """The number of rows, damaged ones included."""
        return int(self._connection.execute("SELECT count(*) FROM results").fetchone()[0])

    def made_by(self) -> list[tuple[int, int | None]]:
        """Return each cell with each environment that made rows of it, by their numbers."""
        return self._connection.execute("SELECT DISTINCT cell, environment FROM results").fetchall()

    def check_count(self, check: StoreCheck) -> StoreCheck:
        """Compare the number of rows read with what the store itself counted, and with the note beside it.

        The note lags behind the store after a kill. Where it is ahead, commits are lost.
        """
        noted, counted, counts = self._noted, self._noted, []
        with suppress(sqlite3.DatabaseError):
            counts = self._connection.execute("SELECT commits, trials FROM committed").fetchall()
        if len(counts) == 1 and all(isinstance(count, int) for count in counts[0]):
            counted = Committed(*counts[0])
        else:
            check.structure = "its count of commits cannot be read"
        check.lost = max(noted.commits - counted.commits, 0)
        check.missing = max((noted if check.lost else counted).trials - check.trials, 0)
        return check

    def check(self, *, structure: bool) -> StoreCheck:
        """Compare all rows with their digests, and the environments' records with theirs.

        With ``structure``, SQLite checks the file too.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
        """
        check = StoreCheck()
        for _ in self.chunks(check):
            pass
        if structure:
            outcome = decoded(self._connection.execute("PRAGMA integrity_check(1)").fetchone()[0])
            check.structure = check.structure if outcome == "ok" else " ".join(outcome.split())
        return check

    def chunks(self, check: StoreCheck) -> Iterator[list[tuple[Any, ...]]]:
        """Yield the rows that fit their digests, of the columns ``READ``, cell by cell, some at a time.

        Texts are UTF-8. When all rows are read, ``check`` is the outcome of the check.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
        """
        cursor = self._connection.execute(f"SELECT {', '.join(READ)} FROM results ORDER BY cell, trial")
        referred: dict[str, set[Any]] = {"environment": set(), "inputs": set()}
        while fetched := cursor.fetchmany(FETCHED):
            check.trials += len(fetched)
            sound = [row for row in fetched if self._fits(*row)]
            if len(sound) < len(fetched):
                check.damaged += [self._named(row) for row in fetched if not self._fits(*row)]
            for column, numbers in referred.items():
                numbers.update(row[READ.index(column)] for row in sound)
            yield sound
        for what, table in (("environment", "environments"), ("inputs", "inputs")):
            records = self.records(table)
            numbers = {*records, *referred[what]} - {None}
            check.records += [f"{what} {number}" for number in sorted(numbers) if not records.get(number)]
        self.check_count(check)

    def sound(self) -> Iterator[tuple[int, Row]]:
        """Yield the number of its cell and the columns but the labels of every row that fits its digest.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
        """
        for _, cell, names, *values in chain.from_iterable(self.chunks(StoreCheck())):
            row = dict(zip(READ[3:], values, strict=True)) | dict(zip(NAMES, self.names.get(names, ()), strict=False))
            yield cell, row | {name: decoded(row[name]) for name in (*NAMES, *TEXTS) if row.get(name) is not None}

    def records(self, table: str) -> dict[int, JsonObject]:
        """Return the records of environments, inputs or history by number, oldest first; a damaged one is empty."""
        return records_of(self._connection, table)

    def _fits(self, noted: object, cell: object, names: object, *values: object) -> bool:
        bound = self._bound(cell, names)
        return bound is not None and digest(bound, values) == noted

    def _named(self, row: Sequence[Any]) -> str:
        """Return a damaged trial in words; its labels may be damaged, too."""
        _, cell, _, trial, *_ = row
        labels = self.cells.selected.get(cell, ("an unknown problem", "an unknown optimizer"))
        if cell not in self.cells.selected and (other := self.cells.all.get(cell)):
            problem, optimizer = other.labels
            labels = problem, f"{optimizer} (not selected)"
        problem, optimizer = (printable(label, LONGEST) for label in labels)
        return f"{optimizer} on {problem}, {f'trial {trial}' if isinstance(trial, int) else 'an unknown trial'}"
