"""Read the rows of a store that are as they were written, and name those that are not."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import chain, islice, product
from typing import TYPE_CHECKING, Any, NamedTuple

from bench.storage.digests import (
    COLUMNS,
    COMPARED,
    INTERRUPTED,
    MEASURED,
    SOUND,
    TRIALS,
    TYPED,
    Counts,
    Digests,
    Place,
    share,
    shares,
)
from bench.storage.schema import KEY, has_digests
from bench.storage.traces import Key
from bench.text import printable

if TYPE_CHECKING:
    from bench.storage.blocks import Block

NAMED = 3  # damaged trials that a sentence names
UNKNOWN = "an unknown problem", "an unknown optimizer"
ROWS = 5_000  # held as Python objects at a time
FETCHED = 500  # rows held as tuples at a time: more would not fit in the processor's cache
CELL, ENVIRONMENT = 1, 3 + MEASURED.index("environment")  # places of columns in a row that is compared
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


class Tally(NamedTuple):
    """What reading a part of a store found: the counts of sound rows, and the damaged ones."""

    counts: Counts
    damaged: list[Place]


class Reader:
    """The rows of an open store at one moment, and which of them fit their digests.

    All rows of a store of the oldest layout, which has no digests, count as sound.

    Attributes:
        uri: with which other processes open the store.
        labels: problem and optimizer of each cell, by its number.
    """

    def __init__(self, connection: sqlite3.Connection, uri: str) -> None:
        self._connection, self.uri = connection, uri
        connection.execute("BEGIN")  # cells and rows of one moment, while a run adds to both
        self._digests = Digests(connection) if has_digests(connection) else None
        if self._digests:
            self.labels = self._digests.labels
        else:
            cells = connection.execute("SELECT id, problem, optimizer FROM cells")
            self.labels = {cell: (problem, optimizer) for cell, problem, optimizer in cells}

    @property
    def shares(self) -> int:
        """The number of processes among which the rows are divided, where several read them."""
        return shares(self._connection)

    def check(self, *, structure: bool) -> StoreCheck:
        """Compare all rows with their digests, and the environments' records with theirs.

        With ``structure``, SQLite checks the file too.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
        """
        if self._digests:
            tally = Tally(self._digests.check(self.uri), self._digests.take())
        else:
            count = self._connection.execute("SELECT count(*) FROM results").fetchone()[0]
            tally = Tally(Counts(count, 0, 0), [])
        found = self.outcome([tally])
        if structure:
            said = str(self._connection.execute("PRAGMA integrity_check(1)").fetchone()[0])
            found.structure = "" if said == "ok" else " ".join(said.split())
        return found

    def outcome(self, tallies: Iterable[Tally]) -> StoreCheck:
        """Return the outcome of reading all parts of the store, and compare the environments' records with theirs."""
        found = StoreCheck(has_digests=self._digests is not None)
        counts, damages = zip(*tallies, strict=True)
        rows, traces, environments = zip(*counts, strict=True)
        damaged = list(chain.from_iterable(damages))
        if self._digests:
            damaged += self._lost(sum(traces))
        found.trials = sum(rows) + len(damaged)
        found.damaged = {(*self.labels.get(cell, UNKNOWN), trial): None for cell, trial in damaged}
        environment = max(environments) if self._digests else 0
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

    def blocks(self, skipped: Collection[str] = (), part: int = 0, parts: int = 1) -> Iterator[Block | Tally]:
        """Yield the trials that fit their digests, cell by cell, in blocks of about ``ROWS``, and at last their tally.

        Args:
            skipped: problems whose trials are compared and counted, but not yielded.
            part: the part of the store to read, from 0 on.
            parts: the number of parts.

        Raises:
            sqlite3.Error: where a part of the rows cannot be read.
            BenchError: where a text is no JSON, in a store of the layout without digests.
        """
        from bench.storage.blocks import pack  # not at the top: it imports pandas

        if self._digests:
            sound = self._digests.sound
            query = f"SELECT {COMPARED} FROM {TRIALS} WHERE {share(part, parts)} AND {TYPED} ORDER BY cell, trial"
        else:
            sound = self._is_known
            query = f"SELECT NULL, {COLUMNS}, NULL FROM results WHERE {share(part, parts)} ORDER BY cell, trial"
        not_wanted = {cell for cell, (problem, _) in self.labels.items() if problem in skipped}
        cursor, columns = self._connection.execute(query), _no_rows()
        rows = traces = environment = 0
        while fetched := cursor.fetchmany(FETCHED):
            if not (some := [row for row in fetched if sound(*row)]):
                continue
            values = [*zip(*some, strict=True)]
            rows += len(some)
            traces += len(some) - values[-1].count(None)
            environment = max(environment, *(each for each in set(values[ENVIRONMENT]) if isinstance(each, int)), 0)
            if not not_wanted.isdisjoint(values[CELL]):
                values = [*zip(*(row for row in some if row[CELL] not in not_wanted), strict=True)]
            for column, more in zip(columns.values(), values[CELL:-1], strict=False):
                column.extend(more)
            if len(columns["cell"]) >= ROWS:
                yield pack(columns, self.labels)
                columns = _no_rows()
        if columns["cell"]:
            yield pack(columns, self.labels)
        yield Tally(Counts(rows, traces, environment), self._digests.take() if self._digests else [])

    def _is_known(self, *row: object) -> bool:
        return row[CELL] in self.labels

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


def _no_rows() -> dict[str, list[Any]]:
    return {name: [] for name in ("cell", "trial", *MEASURED)}


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
