"""The store of a study's folder: one committed SQLite row a trial, written by one process, read by any."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.errors import BenchError
from bench.storage.digests import INTERRUPTED, JSON, MEASURED, SEAL, Digests
from bench.storage.parts import read_parts
from bench.storage.reading import Reader, StoreCheck
from bench.storage.schema import KEY, OLDEST, VERSION, prepare
from bench.storage.traces import Key, Traces, pack
from bench.text import printable
from bench.trial import Trial

if TYPE_CHECKING:
    from bench.storage.blocks import Block

FILE = "trials.sqlite"
READERS = 4  # processes that read a frame: more gain little, as one of them puts it together, and take 0.12 GB each
LARGEST = 100_000_000  # number of a trial; a larger one is damaged
LONGEST = 200  # characters of SQLite's words on an error

REPEATABLE = tuple(name for name in (*MEASURED, "trace") if name != "environment" and not name.endswith("_s"))
"""The columns that must be identical when a trial is made twice."""

BEYOND_REPAIR = "restore it from a copy, or move it away and run the study again"

_ONE = "problem = ? AND optimizer = ? AND trial = ?"


class Keys:
    """A set of trials at one byte each, as a study may have millions."""

    def __init__(self) -> None:
        self._cells: dict[tuple[str, str], bytearray] = {}

    def add(self, problem: str, optimizer: str, number: int) -> None:
        """Add a trial."""
        marks = self._cells.setdefault((problem, optimizer), bytearray())
        if number >= len(marks):
            marks.extend(bytes(number + 1 - len(marks)))
        marks[number] = 1

    def discard(self, key: Key) -> None:
        """Remove a trial, where it is in the set."""
        if key in self:
            self._cells[key[:2]][key[2]] = 0

    def __contains__(self, key: Key) -> bool:
        marks = self._cells.get(key[:2], b"")
        return 0 <= key[2] < len(marks) and marks[key[2]] == 1

    def count(self, problem: str, optimizer: str, trials: int) -> int:
        """Return how many of the first ``trials`` of a cell are in the set."""
        return self._cells.get((problem, optimizer), bytearray()).count(1, 0, trials)


@dataclass
class CellCounts:
    """The counts and times of the stored trials of one optimizer on one problem, both by label."""

    problem: str
    optimizer: str
    status: dict[str, int] = field(default_factory=dict)  # rows by status
    wall_s: float = 0.0  # sum of the finished trials

    @property
    def done(self) -> int:
        """The number of finished trials."""
        return self.status.get("ok", 0)

    @property
    def failed(self) -> int:
        """The number of trials that failed or timed out."""
        return sum(self.status.values()) - self.done


class DamagedStoreError(BenchError):
    """SQLite cannot read the structure of a part of the store."""


def stored(trial: Trial, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a trial's row as :meth:`Store.rows` yields it, from the columns of :func:`bench.trial.as_row`."""
    key = dict(zip(KEY, trial.key, strict=True))
    texts = {name: json.dumps(row[name]) for name in JSON if name in row}
    return {**row, **key, "seed": trial.seed, **texts, **({"trace": pack(row["trace"])} if "trace" in row else {})}


def disagreement(one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Return the first of ``REPEATABLE`` in which two rows of one trial, traces included, differ; "" for none."""
    return next((name for name in REPEATABLE if one.get(name) != other.get(name)), "")


class Store:
    """The trials of one study, in ``trials.sqlite`` of its folder, whose view ``trials`` joins all tables.

    Values are stored as SQLite's 8-byte floats or as JSON with all digits, traces as raw little-endian arrays:
    nothing is rounded and nothing is ever unpickled.
    """

    def __init__(self, folder: Path, file: str = FILE) -> None:
        self.path = folder / file

    @property
    def exists(self) -> bool:
        """Whether the store has been begun, as far as this user may see."""
        return os.path.exists(self.path)  # noqa: PTH110 - Path.exists raises without permission

    @contextmanager
    def _open(self, *, rescue: bool = False) -> Iterator[tuple[sqlite3.Connection, str]]:
        """Yield a connection and its URI; refuse a store of an unknown layout.

        With ``rescue``, SQLite also opens a file that was cut short, or whose schema is damaged in some places.
        """
        try:
            with _uri(self.path) as uri, closing(sqlite3.connect(uri, timeout=30, uri=True)) as connection:
                if rescue:
                    connection.execute("PRAGMA writable_schema = ON")
                version = connection.execute("PRAGMA user_version").fetchone()[0]
                known = OLDEST <= version <= VERSION
                if not known and connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                    raise BenchError(
                        f"the store {self.path} was written by another version of this package; read it with that one, "
                        "or run the study into another folder"
                    )
                yield connection, uri
        except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter for a damaged name in SQLite's message
            if str(error) == INTERRUPTED:
                raise KeyboardInterrupt from error
            raise self._refusal(error) from error

    def _refusal(self, error: Exception) -> BenchError:
        said = f"the store {self.path} cannot be used: {printable(str(error), LONGEST)}"
        code = getattr(error, "sqlite_errorcode", None)
        if code is not None and code & 0xFF == sqlite3.SQLITE_CORRUPT:
            return DamagedStoreError(
                f"{said}; 'bench run' into this folder keeps the trials that can be read and makes the others again"
            )
        if code in (None, sqlite3.SQLITE_ERROR, sqlite3.SQLITE_NOTADB):  # no key, no such table, another file
            return BenchError(f"{said}; {BEYOND_REPAIR}")
        return BenchError(f"{said}; what it holds is kept")

    @contextmanager
    def writer(self) -> Iterator[Writer]:
        """Open the store for writing, creating it where it is missing; every row is committed as it is added.

        The rows of a store without digests get theirs.
        """
        with self._open() as (connection, _):
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA synchronous=NORMAL")  # safe against a killed process; a power cut may cost rows
            yield Writer(connection, prepare(connection))

    @contextmanager
    def _reader(self, *, rescue: bool = False) -> Iterator[Reader | None]:
        """Yield a reader; None for a store that is missing, or whose run was killed before it made tables."""
        if not self.exists:
            yield None
            return
        with self._open(rescue=rescue) as (connection, uri):
            made = connection.execute("PRAGMA user_version").fetchone()[0]
            yield Reader(connection, uri) if made else None

    def check(self, *, structure: bool = False) -> StoreCheck:
        """Compare every row and trace with its digest; with ``structure``, SQLite also checks the file.

        Raises:
            DamagedStoreError: when SQLite cannot read all rows.
        """
        with self._reader() as reader:
            return reader.check(structure=structure) if reader else StoreCheck()

    def sound_rows(self, found: StoreCheck, *, traces: bool = False) -> Iterator[dict[str, Any]]:
        """Yield every row that is as it was written, cell by cell, as :meth:`rows` does.

        Args:
            found: what :meth:`check` returned just before; rows are compared again only where some are damaged.
            traces: whether rows have their traces.

        Raises:
            BenchError: when there is no store.
            DamagedStoreError: when SQLite cannot read all rows.
        """
        self._require()
        return self._read((*MEASURED, "trace") if traces else MEASURED, found)

    def blocks(self, skipped: Collection[str] = (), *, several: bool = False) -> Iterator[Block | StoreCheck]:
        """Yield the trials that are as they were written, in blocks, and at last what :meth:`check` would return.

        Args:
            skipped: problems whose trials are checked, but not yielded.
            several: whether several processes read a large store.

        Raises:
            LostPartError: when one of several processes ended too early.
            BenchError: when there is no store.
            DamagedStoreError: when SQLite cannot read all rows.
        """
        self._require()
        with self._reader() as reader:
            if reader:
                yield from read_parts(reader, skipped, min(READERS, reader.shares) if several else 1)
            else:
                yield StoreCheck()

    def count(self) -> int:
        """Return the number of stored trials, damaged or not."""
        return sum(count for (count,) in self._select("SELECT count(*) FROM results"))

    def _read(self, names: Sequence[str], found: StoreCheck) -> Iterator[dict[str, Any]]:
        with self._reader() as reader:
            if reader:
                yield from reader.rows(names, compared=not found.sound)

    def copy(self, file: Path) -> None:
        """Write all that the store holds at one moment into a new file, one without a log beside it.

        The same rows give the same bytes, wherever they lie in this store.

        Raises:
            BenchError: when there is no store.
            DamagedStoreError: when SQLite cannot read all of it.
        """
        self._require()
        with self._open() as (connection, _):
            connection.execute("VACUUM INTO ?", (str(file),))
            with closing(sqlite3.connect(file)) as copy:
                copy.execute("PRAGMA schema_version = 1")  # VACUUM counts it up from that of this store

    def rescued_rows(self, trials: int) -> Iterator[dict[str, Any]]:
        """Yield every sound row, with its trace, that can be read from a store whose structure is damaged.

        The first ``trials`` trials of each cell are also looked up one by one.

        Raises:
            DamagedStoreError: when not even the cells can be read.
        """
        done = Keys()
        with self._reader(rescue=True) as reader:
            for row in reader.rescue((*MEASURED, "trace"), trials) if reader else ():
                key = row["problem"], row["optimizer"], row["trial"]
                if key not in done:
                    done.add(*key)
                    yield row

    def keys(self, *, finished_only: bool = False) -> Keys:
        """Return the stored trials, or the finished ones only; damaged ones are not left out."""
        keys = Keys()
        labels = {cell: (problem, optimizer) for cell, problem, optimizer in self._select("SELECT * FROM cells")}
        query = f"SELECT cell, trial FROM results WHERE trial BETWEEN 0 AND {LARGEST}"
        for cell, trial in self._select(query + (" AND status = 'ok'" if finished_only else "")):
            if cell in labels:
                keys.add(*labels[cell], trial)
        return keys

    def cells(self) -> list[CellCounts]:
        """Return the counts of each cell."""
        cells: dict[tuple[str, str], CellCounts] = {}
        for problem, optimizer, status, count, wall in self._select(
            "SELECT problem, optimizer, status, count(*), coalesce(sum(wall_s), 0)"
            " FROM results JOIN cells ON cells.id = cell GROUP BY cell, status"
        ):
            cell = cells.setdefault((problem, optimizer), CellCounts(problem, optimizer))
            cell.status[status] = count
            cell.wall_s += wall
        return list(cells.values())

    def undeclared(self) -> dict[str, int]:
        """Return the number of finished trials that ended within the budget and declared no reason, by optimizer."""
        return dict(
            self._select(
                "SELECT optimizer, count(*) FROM results JOIN cells ON cells.id = cell"
                " WHERE status = 'ok' AND stop = 'undeclared' GROUP BY optimizer ORDER BY optimizer"
            )
        )

    def rows(self, where: str = "", *, traces: bool = False) -> Iterator[dict[str, Any]]:
        """Yield every row that meets an SQL condition, cell by cell, damaged or not.

        ``x`` and ``figures`` are JSON texts, a trace is bytes.

        Raises:
            BenchError: when there is no store.
        """
        self._require()
        query, names = _query(where, traces=traces)
        return (dict(zip(names, row, strict=True)) for row in self._select(query))

    def find(self, problem: str, optimizer: str, trial: int) -> dict[str, Any] | None:
        """Return the row of one trial with its trace, as :meth:`rows` yields it, or None."""
        query, names = _query(_ONE, traces=True)
        found = list(self._select(query, (problem, optimizer, trial)))
        return dict(zip(names, found[0], strict=True)) if found else None

    def _require(self) -> None:
        if not self.exists:
            raise BenchError(f"there is no {FILE} in {self.path.parent}; give the folder that 'bench run' wrote")

    def traces(self, found: StoreCheck | None = None) -> Traces:
        """Return the anytime traces by (problem, optimizer, trial); failed trials have none.

        After a :meth:`check` that found damage, traces of damaged trials are left out.
        """
        try:
            return Traces.read(self._read(["trace"], found or StoreCheck()))
        except ValueError as error:
            raise BenchError(f"the store {self.path} is damaged: a trace cannot be read") from error

    def made(self) -> dict[int, int]:
        """Return the number of rows that each environment made, by the environment's number."""
        query = "SELECT environment, count(*) FROM results WHERE environment IS NOT NULL GROUP BY environment"
        return {int(number): int(count) for number, count in self._select(query)}

    def environments(self, copies: Sequence[object] | None = None) -> dict[int, dict[str, Any]]:
        """Return the environments that rows refer to, by their numbers, oldest first.

        A record that does not fit its digest is empty. To rescue a damaged store's, give ``copies`` of records, none or
        some: a record is taken from them where one of them fits the digest.
        """
        with self._reader(rescue=copies is not None) as reader:
            return reader.environments(copies or ()) if reader else {}

    def _select(self, query: str, values: Sequence[object] = ()) -> Iterator[tuple[Any, ...]]:
        """Yield a query's rows without checking them; none of a store that is missing or has no tables yet."""
        if not self.exists:
            return
        with self._open() as (connection, _):
            if connection.execute("PRAGMA user_version").fetchone()[0]:
                connection.text_factory = _decoded
                yield from connection.execute(query, values)


def _decoded(text: bytes) -> str:
    """Return a text, which damage may have left no UTF-8."""
    return text.decode(errors="replace")


class Writer:
    """The only writer of an open store: adds and removes rows."""

    def __init__(self, connection: sqlite3.Connection, digests: Digests) -> None:
        self._connection = connection
        self._digests = digests
        self._cells = self._stored_cells()

    def add(self, trial: Trial, row: Mapping[str, Any], environment: int | None = None) -> None:
        """Commit one trial's row, of the columns of :func:`bench.trial.as_row`; missing ones are stored as NULL.

        It replaces a failed row of the same trial, but never a finished one.
        """
        with self.transaction():
            self.put(stored(trial, row) | {"environment": environment})

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Commit all rows put in this context, or none of them."""
        try:
            with self._connection:
                yield
        except BaseException:
            self._cells = self._stored_cells()  # without the cells of rows that were not committed
            raise

    def put(self, row: Mapping[str, Any]) -> None:
        """Add a row as :meth:`Store.rows` yields it, within :meth:`transaction`."""
        cell, number = self._cell(row["problem"], row["optimizer"]), row["trial"]
        self._connection.execute("DELETE FROM results WHERE cell = ? AND trial = ? AND status != 'ok'", (cell, number))
        self._connection.execute(
            f"INSERT INTO results (cell, trial, {', '.join(MEASURED)}) VALUES (?, ?{', ?' * len(MEASURED)})",
            [cell, number, *(row.get(name) for name in MEASURED)],
        )
        if row.get("trace") is not None:  # one may have stayed when another program deleted the row
            self._connection.execute("INSERT OR REPLACE INTO traces VALUES (?, ?, ?)", (cell, number, row["trace"]))
        else:
            self._connection.execute("DELETE FROM traces WHERE cell = ? AND trial = ?", (cell, number))
        self._connection.execute(f"{SEAL} WHERE cell = ? AND trial = ?", (cell, number))

    def find(self, problem: str, optimizer: str, trial: int) -> dict[str, Any] | None:
        """Return the row of one trial with its trace, as :meth:`Store.rows` yields it, or None."""
        query, names = _query(_ONE, traces=True)
        found = self._connection.execute(query, (problem, optimizer, trial)).fetchone()
        return dict(zip(names, found, strict=True)) if found else None

    def environment(self, record: Mapping[str, Any]) -> int:
        """Commit an environment's record and return its number; equal records have one number."""
        text = json.dumps(record)
        with self._connection:
            known = self._connection.execute("SELECT id FROM environments WHERE record = ?", (text,)).fetchone()
            if known is not None:
                return int(known[0])
            made = self._connection.execute("INSERT INTO environments (record) VALUES (?)", (text,))
            number = int(made.lastrowid or 0)
            self._record(number, text)
        return number

    def change(self, number: int, record: Mapping[str, Any]) -> None:
        """Commit a changed record of an environment."""
        with self._connection:
            self._record(number, json.dumps(record))

    def _record(self, number: int, text: str) -> None:
        values = text, self._digests.record(number, text.encode()), number
        self._connection.execute("UPDATE environments SET record = ?, digest = ? WHERE id = ?", values)

    def remove(self, problems: list[str], optimizers: list[str], *, failed_only: bool = False) -> int:
        """Remove the rows of all cells of these problems and optimizers, or only failed rows; return their number."""
        cells = [(self._cells.get((problem, optimizer)),) for problem in problems for optimizer in optimizers]
        with self._connection:
            if failed_only:  # these have no traces
                done = self._connection.executemany("DELETE FROM results WHERE cell = ? AND status != 'ok'", cells)
            else:
                self._connection.executemany("DELETE FROM traces WHERE cell = ?", cells)
                done = self._connection.executemany("DELETE FROM results WHERE cell = ?", cells)
        return int(done.rowcount)

    def _stored_cells(self) -> dict[tuple[str, str], int]:
        """Return the cells' numbers by (problem, optimizer)."""
        rows = self._connection.execute("SELECT id, problem, optimizer FROM cells")
        return {(problem, optimizer): number for number, problem, optimizer in rows}

    def _cell(self, problem: str, optimizer: str) -> int:
        key = problem, optimizer
        if key not in self._cells:
            made = self._connection.execute("INSERT INTO cells (problem, optimizer) VALUES (?, ?)", key)
            self._cells[key] = int(made.lastrowid or 0)
            self._digests.add(self._cells[key], problem, optimizer)
        return self._cells[key]


def _query(where: str, *, traces: bool) -> tuple[str, tuple[str, ...]]:
    """Return the query for the rows of a condition, and the names of its columns."""
    names = (*KEY, *MEASURED, "trace") if traces else (*KEY, *MEASURED)
    query = f"SELECT {', '.join(names)} FROM results JOIN cells ON cells.id = cell"
    query += " LEFT JOIN traces USING (cell, trial)" if traces else ""
    return query + (f" WHERE {where}" if where else "") + " ORDER BY cell, trial", names


@contextmanager
def _uri(path: Path) -> Iterator[str]:
    """Yield the URI with which SQLite opens a store, also in a folder that cannot be written.

    SQLite writes files beside a store even to read it. In a read-only folder it can use the index that a running or
    killed run left there; without an index the URI must declare the store immutable. Rows in a write-ahead log without
    an index, as in a copy made by hand, are found only by writing, so such a store is read from a temporary copy.
    """
    uri = path.resolve().as_uri()
    log, index = (path.with_name(f"{path.name}-{beside}") for beside in ("wal", "shm"))
    if not path.exists() or os.access(path.parent, os.W_OK):
        yield uri
    elif index.exists():
        yield f"{uri}?mode=ro"
    elif not log.exists() or not log.stat().st_size:
        yield f"{uri}?immutable=1"
    else:
        with tempfile.TemporaryDirectory() as folder:
            for each in (path, log):
                shutil.copy(each, folder)
            yield (Path(folder) / path.name).as_uri()
