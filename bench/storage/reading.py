"""Read the rows of a store that are as they were written, and name those that are not."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice, product
from typing import Any

from bench.storage.digests import INTERRUPTED, SOUND, TRIALS, Digests, Place
from bench.storage.schema import KEY, has_digests
from bench.storage.traces import Key
from bench.text import printable

NAMED = 3  # damaged trials that a sentence names
UNKNOWN = "an unknown problem", "an unknown optimizer"
JSON = ("x", "figures")  # columns
SLICE = 5_000  # rows held as Python objects at a time
ROWS = 500  # rows held as tuples at a time: more would not fit in the processor's cache
LONGEST = 100  # characters of a label, which may be damaged too


@dataclass
class StoreCheck:
    """The outcome of reading a store's rows: which of them are not as they were written.

    A damaged trial counts as missing: it is left out of results, and the next run makes it again.
    """

    trials: int = 0  # rows read, damaged ones included
    damaged: dict[Key, None] = field(default_factory=dict)  # trials, in the order in which they were found
    environments: list[int] = field(default_factory=list)  # numbers of damaged records
    has_digests: bool = True  # false for a store of an older version, in which a change cannot be noticed
    structure: str = ""  # SQLite's words on damage of the file's structure

    @property
    def sound(self) -> bool:
        """Whether no damage was found."""
        return not (self.damaged or self.environments or self.structure)

    @property
    def sentence(self) -> str:
        """The outcome in one sentence, without a full stop."""
        parts = []
        if self.damaged:
            named = "; ".join(_name(*key) for key in islice(self.damaged, NAMED))
            more = f"; and {len(self.damaged) - NAMED:,} more" if len(self.damaged) > NAMED else ""
            parts.append(f"{len(self.damaged):,} of {self.trials:,} trials are damaged ({named}{more})")
        if self.environments:
            parts.append(f"the record of environment {', '.join(map(str, self.environments))} is damaged")
        if self.structure:
            parts.append(f"the structure of the file is damaged ({self.structure})")
        if parts:
            lost = "; damaged trials count as missing, and 'bench run' makes them again"
            return ", and ".join(parts) + lost * bool(self.damaged or self.structure)
        if not self.has_digests:
            return (
                f"a change of the {self.trials:,} trials cannot be noticed, as an older version stored them without "
                "digests; the next 'bench run' adds digests"
            )
        return f"all {self.trials:,} trials are as they were written"


def _name(problem: str, optimizer: str, trial: int) -> str:
    number = f"trial {trial}" if trial >= 0 else "an unknown trial"
    return f"{printable(optimizer, LONGEST)} on {printable(problem, LONGEST)}, {number}"


class Reader:
    """The rows of an open store at one moment, and which of them fit their digests.

    All rows of a store of the oldest layout, which has no digests, count as sound.
    """

    def __init__(self, connection: sqlite3.Connection, uri: str) -> None:
        self._connection, self._uri = connection, uri
        connection.execute("BEGIN")  # cells and rows of one moment, while a run adds to both
        self._digests = Digests(connection) if has_digests(connection) else None
        if self._digests:
            self.labels = self._digests.labels
        else:
            cells = connection.execute("SELECT id, problem, optimizer FROM cells")
            self.labels = {cell: (problem, optimizer) for cell, problem, optimizer in cells}

    def check(self, *, structure: bool) -> StoreCheck:
        """Compare all rows with their digests, and the environments' records with theirs.

        With ``structure``, SQLite checks the file too.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
        """
        found = StoreCheck(has_digests=self._digests is not None)
        if structure:
            said = str(self._connection.execute("PRAGMA integrity_check(1)").fetchone()[0])
            found.structure = "" if said == "ok" else " ".join(said.split())
        environment = 0
        if self._digests:
            sound = self._digests.check(self._uri)
            damaged = [*self._digests.take(), *self._lost(sound.traces)]
            found.trials, environment = sound.rows + len(damaged), sound.environment
            found.damaged = {(*self.labels.get(cell, UNKNOWN), trial): None for cell, trial in damaged}
        else:
            found.trials = self._connection.execute("SELECT count(*) FROM results").fetchone()[0]
        known = self.environments()
        found.environments = [
            number for number in sorted({*known, *range(1, environment + 1)}) if not known.get(number)
        ]
        return found

    def _lost(self, traces: int) -> list[Place]:
        """Return the trials that have a trace but no row, as where damage hides a part of a page.

        ``traces`` is the number of rows that have a trace and are sound.
        """
        (stored,) = self._connection.execute("SELECT count(*) FROM traces").fetchone()
        if stored == traces:
            return []
        query = "SELECT traces.cell, traces.trial FROM traces LEFT JOIN results USING (cell, trial) WHERE seed IS NULL"
        return [(cell, trial) for cell, trial in self._connection.execute(query)]

    def rows(
        self, names: Sequence[str], where: str = "1", values: Sequence[object] = (), *, compared: bool = True
    ) -> Iterator[dict[str, Any]]:
        """Yield key and named columns of every row that meets a condition and fits its digest, cell by cell.

        Where rows were checked before, ``compared=False`` spares it here.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
        """
        sound = SOUND if compared and self._digests else "1"
        tables = TRIALS if sound == SOUND or "trace" in names else "results"
        query = f"SELECT cell, trial, {', '.join(names)} FROM {tables} WHERE {where} AND {sound} ORDER BY cell, trial"
        columns = (*KEY, *names)
        for cell, *row in self._connection.execute(query, values):
            if cell in self.labels:
                yield dict(zip(columns, (*self.labels[cell], *row), strict=True))

    def columns(self, names: Sequence[str], *, compared: bool = True) -> Iterator[dict[str, list[Any]]]:
        """Yield ``cell``, ``trial`` and named columns of the rows that fit their digests, cell by cell.

        Each dictionary holds about ``SLICE`` rows, as a study may have millions; JSON texts are UTF-8. Where rows were
        checked before, ``compared=False`` spares it here.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
        """
        sound = SOUND if compared and self._digests else "1"
        read = ", ".join(f"CAST({name} AS BLOB)" if name in JSON else name for name in names)
        tables = TRIALS if sound == SOUND else "results"
        query = f"SELECT cell, trial, {read} FROM {tables} WHERE {sound} ORDER BY cell, trial"
        cursor, columns = self._connection.execute(query), self._empty(names)
        while rows := cursor.fetchmany(ROWS):
            if not self.labels.keys() >= {row[0] for row in rows}:  # in a store without digests
                rows = [row for row in rows if row[0] in self.labels]
            for column, values in zip(columns.values(), zip(*rows, strict=True), strict=False):
                column.extend(values)
            if len(columns["cell"]) >= SLICE:
                yield columns
                columns = self._empty(names)
        if columns["cell"]:
            yield columns

    @staticmethod
    def _empty(names: Sequence[str]) -> dict[str, list[Any]]:
        return {name: [] for name in ("cell", "trial", *names)}

    def rescue(self, names: Sequence[str], trials: int) -> Iterator[dict[str, Any]]:
        """Yield what :meth:`rows` can read, then the first ``trials`` trials of each cell that can be looked up.

        Raises:
            sqlite3.OperationalError: where SQLite does not even find the tables.
        """
        self._connection.execute(f"SELECT {', '.join(names)} FROM {TRIALS} LIMIT 0")
        with _what_can_be_read():
            yield from self.rows(names)
        for cell, number in product(self.labels, range(trials)):
            with _what_can_be_read():
                yield from self.rows(names, "results.cell = ? AND results.trial = ?", (cell, number))

    def environments(self, copies: Sequence[object] = ()) -> dict[int, dict[str, Any]]:
        """Return the environments' records by number, oldest first.

        A damaged one is taken from the ``copies``, or else empty.
        """
        digest = "CAST(digest AS BLOB)" if self._digests else "NULL"
        query = f"SELECT id, CAST(record AS BLOB), {digest} FROM environments ORDER BY id"
        records = {}
        for number, text, noted in self._connection.execute(query):
            texts = [text, *(json.dumps(copy).encode() for copy in copies)]
            sound = (each for each in texts if not self._digests or self._digests.record(number, each) == noted)
            records[number] = _record(next(sound, None))
        return records


@contextmanager
def _what_can_be_read() -> Iterator[None]:
    """Suppress SQLite's errors, but no KeyboardInterrupt: it would cost a sound row."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        if str(error) == INTERRUPTED:
            raise


def _record(text: bytes | None) -> dict[str, Any]:
    """Return a record from its JSON text, an empty one where that is damaged."""
    try:
        record = json.loads(text or "")
    except (ValueError, RecursionError):
        return {}
    return record if isinstance(record, dict) else {}
