"""The store of a study's folder: one committed SQLite row a trial, written by one process, read by any."""

from __future__ import annotations

import os
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.storage import committed
from bench.storage.committed import Committed, Note
from bench.storage.reading import Reader, StoreCheck
from bench.storage.rows import COLUMNS, KEY
from bench.storage.schema import VERSION, prepare
from bench.storage.traces import Key, Traces
from bench.storage.writing import Writer, select
from bench.text import printable

FILE = "trials.sqlite"
LARGEST = 100_000_000  # number of a trial; a larger one is damaged
LONGEST = 200  # characters of SQLite's words on an error

BEYOND_REPAIR = "restore it from a copy, or move it away and run the study again"


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


class Store:
    """The trials of one study, in ``trials.sqlite`` of its folder, whose view ``trials`` joins all tables.

    Values are stored as 8-byte floats, nothing is rounded and nothing is ever unpickled.
    """

    def __init__(self, folder: Path, file: str = FILE) -> None:
        self.path = folder / file

    @property
    def exists(self) -> bool:
        """Whether the store has been begun, as far as this user may see."""
        return os.path.exists(self.path)  # noqa: PTH110 - Path.exists raises without permission

    # what is as it was written

    def check(self, *, structure: bool = False) -> StoreCheck:
        """Compare every row with its digest; with ``structure``, SQLite also checks the file.

        Raises:
            DamagedStoreError: when SQLite cannot read all rows.
        """
        with self._reader() as reader:
            return reader.check(structure=structure) if reader else self._no_rows()

    def count(self) -> StoreCheck:
        """Compare the number of rows with that of the rows committed, without a look into them."""
        with self._reader() as reader:
            return reader.count(StoreCheck(), reader.rows) if reader else self._no_rows()

    @contextmanager
    def reader(self) -> Iterator[Reader | None]:
        """Open the store to read its rows at one moment; yield None where no table has been made yet.

        Raises:
            BenchError: when there is no store.
            DamagedStoreError: when SQLite cannot read all rows.
        """
        self._require()
        with self._reader() as reader:
            yield reader

    def sound_rows(self) -> Iterator[dict[str, Any]]:
        """Yield every row that fits its digest, cell by cell, as :meth:`rows` does; raises as :meth:`reader` does."""
        with self.reader() as reader:
            yield from reader.sound() if reader else ()

    def rescued_rows(self, trials: int) -> Iterator[dict[str, Any]]:
        """Yield every sound row that can be read from a store that may be damaged anywhere, some perhaps twice.

        Where SQLite cannot read a whole cell, its first ``trials`` trials are looked up one by one.

        Raises:
            DamagedStoreError: when not even the cells can be read.
        """
        with self._reader(rescue=True) as reader:
            yield from reader.rescue(trials) if reader else ()

    def traces(self) -> Traces:
        """Return the anytime traces of sound trials by (problem, optimizer, trial); failed trials have none."""
        try:
            return Traces.read(self.sound_rows() if self.exists else ())
        except ValueError as error:
            raise BenchError(f"the store {self.path} is damaged: a trace cannot be read") from error

    def environments(self, copies: Sequence[object] | None = None) -> dict[int, dict[str, Any]]:
        """Return the environments that rows refer to, by their numbers, oldest first.

        A record that does not fit its digest is empty. To rescue a damaged store's, give ``copies`` of records, none or
        some: a record is taken from them where one of them fits the digest.
        """
        with self._reader(rescue=copies is not None) as reader:
            return reader.environments(copies or ()) if reader else {}

    # what is stored, compared or not

    def rows(self, where: str = "", columns: tuple[str, ...] = COLUMNS) -> Iterator[dict[str, Any]]:
        """Yield the columns of every row that meets an SQL condition, cell by cell, damaged or not.

        Raises:
            BenchError: when there is no store.
        """
        self._require()
        return (dict(zip(columns, row, strict=True)) for row in self._select(select(where, columns)))

    def find(self, problem: str, optimizer: str, trial: int) -> dict[str, Any] | None:
        """Return the row of one trial, as :meth:`rows` yields it, or None."""
        query = select("problem = ? AND optimizer = ? AND trial = ?")
        found = next(self._select(query, (problem, optimizer, trial)), None)
        return dict(zip(COLUMNS, found, strict=True)) if found else None

    def keys(self, *, finished_only: bool = False) -> Keys:
        """Return the stored trials, or the finished ones only; damaged ones are not left out."""
        keys = Keys()
        condition = f"trial BETWEEN 0 AND {LARGEST}" + (" AND status = 'ok'" if finished_only else "")
        for key in self._select(select(condition, KEY)):
            keys.add(*key)
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

    def made(self) -> dict[int, int]:
        """Return the number of rows that each environment made, by the environment's number."""
        query = "SELECT environment, count(*) FROM results WHERE environment IS NOT NULL GROUP BY environment"
        return {int(number): int(count) for number, count in self._select(query)}

    # opening it

    @contextmanager
    def writer(self, *, anew: bool = False) -> Iterator[Writer]:
        """Open the store for writing, creating it where it is missing; every row is committed as it is added.

        Args:
            anew: begin a store that takes the place of a damaged one, and note nothing beside it.

        Raises:
            DamagedStoreError: when committed trials are missing.
            BenchError: when it cannot be written.
        """
        if not anew and not (found := self.count()).sound:
            raise DamagedStoreError(f"the store {self.path} cannot be written: {found.sentence}")
        with self._open() as connection:
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA synchronous=NORMAL")  # safe against a killed process; a power cut may cost rows
            prepare(connection, committed.read(self.path.parent))
            with closing(Note(self.path.parent, kept=not anew)) as note:
                yield Writer(connection, self.path, note)

    def copy(self, file: Path) -> None:
        """Write all that the store holds at one moment into a new file, one without a log beside it.

        The same rows give the same bytes, wherever they lie in this store.

        Raises:
            BenchError: when there is no store.
            DamagedStoreError: when SQLite cannot read all of it.
        """
        self._require()
        with self._open() as connection:
            connection.execute("VACUUM INTO ?", (str(file),))
            with closing(sqlite3.connect(file)) as copy, copy:
                copy.execute("UPDATE committed SET commits = 0")
                copy.execute("PRAGMA schema_version = 1")  # VACUUM counts it up from that of this store

    @contextmanager
    def _open(self, *, rescue: bool = False) -> Iterator[sqlite3.Connection]:
        """Yield a connection; refuse a store of another layout.

        With ``rescue``, SQLite also opens a file that was cut short, or whose schema is damaged in some places.
        """
        try:
            with _uri(self.path) as uri, closing(sqlite3.connect(uri, timeout=30, uri=True)) as connection:
                if rescue:
                    connection.execute("PRAGMA writable_schema = ON")
                version = _layout(connection)
                if version != VERSION and connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                    raise BenchError(
                        f"the store {self.path} was written by {_author(connection)} in layout {version}, and this "
                        f"version reads layout {VERSION}; export it with the version that wrote it ('bench export "
                        "--format csv') and import that, or run the study into another folder"
                    )
                yield connection
        except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter for a damaged name in SQLite's message
            raise self._refusal(error) from error

    def _refusal(self, error: Exception) -> BenchError:
        said = f"the store {self.path} cannot be used: {printable(str(error), LONGEST)}"
        code = getattr(error, "sqlite_errorcode", None)
        if code is not None and code & 0xFF == sqlite3.SQLITE_CORRUPT:
            return DamagedStoreError(
                f"{said}; 'bench run' into this folder keeps the trials that can be read and makes the others again"
            )
        if code in (None, sqlite3.SQLITE_ERROR, sqlite3.SQLITE_NOTADB):  # no such table, another file
            return BenchError(f"{said}; {BEYOND_REPAIR}")
        return BenchError(f"{said}; what it holds is kept")

    @contextmanager
    def _reader(self, *, rescue: bool = False) -> Iterator[Reader | None]:
        """Yield a reader; None for a store that is missing, or whose run was killed before it made tables."""
        noted = committed.read(self.path.parent)  # before the store is opened, which a run may write to
        if not self.exists:
            yield None
            return
        with self._open(rescue=rescue) as connection:
            yield Reader(connection, noted) if _layout(connection) else None

    def _no_rows(self) -> StoreCheck:
        return StoreCheck().count(0, Committed(), committed.read(self.path.parent))

    def _require(self) -> None:
        if not self.exists:
            raise BenchError(f"there is no {FILE} in {self.path.parent}; give the folder that 'bench run' wrote")

    def _select(self, query: str, values: Sequence[object] = ()) -> Iterator[tuple[Any, ...]]:
        """Yield a query's rows without checking them; none of a store that is missing or has no tables yet."""
        if not self.exists:
            return
        with self._open() as connection:
            if connection.execute("PRAGMA user_version").fetchone()[0]:
                connection.text_factory = _decoded
                yield from connection.execute(query, values)


def _decoded(text: bytes) -> str:
    """Return a text, which damage may have left no UTF-8."""
    return text.decode(errors="replace")


def _layout(connection: sqlite3.Connection) -> int:
    return int(connection.execute("PRAGMA user_version").fetchone()[0])


def _author(connection: sqlite3.Connection) -> str:
    """Return the version that wrote a store of another layout, as far as the store says it."""
    query = "SELECT json_extract(record, '$.packages.\"backlash-bench\"') FROM environments ORDER BY id DESC LIMIT 1"
    with suppress(sqlite3.Error, TypeError):
        if version := connection.execute(query).fetchone()[0]:
            return f"backlash-bench {printable(str(version), LONGEST)}"
    return "another version of this package"


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
