"""The store of a study's folder: one committed SQLite row a trial, written by one process, read by any."""

from __future__ import annotations

import json
import os
import sqlite3
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.contract.objective import IMPROVEMENT, Logs
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.helpers.text import printable, short_hash
from bench.storage import committed
from bench.storage.cells import Cells, read
from bench.storage.committed import Committed
from bench.storage.reading import Key, Reader, StoreCheck, Traces
from bench.storage.rows import COLUMNS, decoded
from bench.storage.schema import SELECTED, VERSION, layout, prepare, strange
from bench.storage.writing import Writer
from bench.study.cell import Labels
from bench.trial.columns import Row

FILE = "trials.sqlite"
LONGEST = 200  # characters of SQLite's words on an error

RESTORE = "restore it from a copy, or move it away and run the study again"


@dataclass
class CellCounts:
    """The counts, times and ends of the stored trials of one optimizer on one problem, both by label."""

    problem: str
    optimizer: str
    status: Counter[str] = field(default_factory=Counter)  # rows by status
    wall_s: float = 0.0  # sum of the finished trials
    stops: Counter[str | None] = field(default_factory=Counter)  # finished trials by what ended them
    most: int = 0  # evaluations of a finished trial

    @property
    def done(self) -> int:
        """The number of finished trials."""
        return self.status.get("ok", 0)

    @property
    def failed(self) -> int:
        """The number of trials that failed or timed out."""
        return sum(self.status.values()) - self.done


class Store:
    """The trials of one study, in ``trials.sqlite`` of its folder, whose view ``trials`` joins all tables.

    Values are stored as 8-byte floats, nothing is rounded and nothing is ever unpickled.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE

    @property
    def exists(self) -> bool:
        """Whether the store has been begun, as far as this user may see."""
        return os.path.exists(self.path)  # noqa: PTH110 - Path.exists raises without permission

    # what is as it was written

    def check(self, *, structure: bool = False) -> StoreCheck:
        """Compare every row with its digest; with ``structure``, SQLite also checks the file.

        Raises:
            BenchError: when SQLite cannot read all rows.
        """
        with self.reader() as reader:
            return reader.check(structure=structure)

    def check_count(self) -> StoreCheck:
        """Compare the number of rows with that of the rows committed, without a look into them."""
        with self.reader() as reader:
            return reader.check_count(StoreCheck(reader.rows))

    @contextmanager
    def reader(self) -> Iterator[Reader]:
        """Open the store to read its rows at one moment; a missing one has none.

        Raises:
            BenchError: when SQLite cannot read all rows.
        """
        noted = committed.read(self.path.parent)  # before the store is opened, which a run may write to
        with self._read() as connection:
            yield Reader(connection, noted)

    def records(self, table: str) -> dict[int, JsonObject]:
        """Return the records of environments, inputs or history by number, oldest first; a damaged one is empty."""
        with self.reader() as reader:
            return reader.records(table)

    # what is stored, compared or not

    def traces(self, shown: Mapping[int, Labels] | None = None) -> Traces:
        """Return the anytime traces of trials by (problem, optimizer, trial); failed trials have none.

        ``shown`` are the labels of the cells that count, by their numbers; by default those selected.
        """
        packed = {(*key,): trace for *key, trace in self._of_cells("trial, trace", shown, "trace IS NOT NULL")}
        if not all(isinstance(trace, bytes) and len(trace) % IMPROVEMENT == 0 for trace in packed.values()):
            raise BenchError(f"the store {self.path} is damaged: a trace cannot be read; {RESTORE}")
        return Traces(packed)

    def logs(self, shown: Mapping[int, Labels] | None = None) -> Iterator[tuple[str, str, int, Logs]]:
        """Yield problem, optimizer and number of the trials with a log, and the log; ``shown`` as for traces."""
        for *key, log in self._of_cells("trial, log", shown, "log IS NOT NULL"):
            yield *key, json.loads(log)

    def rows(self, where: str = "1", values: Sequence[object] = (), columns: Sequence[str] = COLUMNS) -> Iterator[Row]:
        """Yield the columns of every selected row that meets an SQL condition, cell by cell, damaged or not."""
        query = f"SELECT {', '.join(columns)} FROM {SELECTED} WHERE {where} ORDER BY results.cell, trial"
        return (dict(zip(columns, row, strict=True)) for row in self._select(query, values))

    def find(self, problem: str, optimizer: str, trial: int) -> Row | None:
        """Return the row of one trial, as :meth:`rows` yields it, or None."""
        one = "selected.problem = ? AND selected.optimizer = ? AND trial = ?"
        return next(self.rows(one, (problem, optimizer, trial)), None)

    def held(self) -> Cells:
        """Return the cells of the store, and which of them its last study selects."""
        with self._read() as connection:
            return read(connection)

    def keys(self, *, finished_only: bool = False, shown: Mapping[int, Labels] | None = None) -> set[Key]:
        """Return the stored trials, or the finished ones only; ``shown`` as in :meth:`traces`."""
        return {(*key,) for key in self._of_cells("trial", shown, "status = 'ok'" if finished_only else "1")}

    def cells(self, shown: Mapping[int, Labels] | None = None) -> list[CellCounts]:
        """Return the counts of each cell that has trials; ``shown`` as in traces."""
        cells: dict[Labels, CellCounts] = {}
        counted = "status, stop, count(*), coalesce(sum(wall_s), 0), coalesce(max(nfev), 0)"
        for *labels, status, stop, count, wall, most in self._of_cells(counted, shown, "1 GROUP BY cell, status, stop"):
            cell = cells.setdefault((*labels,), CellCounts(*labels))
            cell.status[status] += count
            cell.wall_s += wall
            if status == "ok":
                cell.stops[stop] += count
                cell.most = max(cell.most, most)
        return list(cells.values())

    def made(self) -> dict[int, int]:
        """Return the number of rows that each environment made, by the environment's number."""
        counted = "SELECT environment, count(*) FROM results WHERE environment IS NOT NULL GROUP BY environment"
        return dict(self._select(counted))

    def undeclared(self) -> dict[str, int]:
        """Return the number of finished trials that ended within the budget and declared no reason, by optimizer."""
        found = Counter[str]()
        for cell in self.cells():
            found[cell.optimizer] += cell.stops["undeclared"]
        return dict(sorted((+found).items()))

    def state(self) -> str:
        """Return a hash of what a report is about: the trials that are selected, and what runs have selected."""
        columns = "results.cell, trial, results.digest, selected.problem, selected.optimizer"
        trials = [*self._select(f"SELECT {columns} FROM {SELECTED} ORDER BY results.cell, trial")]
        runs = [*self._select("SELECT record FROM history WHERE record NOT LIKE '{\"look\"%'")]
        return short_hash(repr((trials, runs)))

    # opening it

    @contextmanager
    def writer(self) -> Iterator[Writer]:
        """Open the store for writing, creating it where it is missing; every row is committed as it is added.

        Raises:
            BenchError: when committed trials are missing, and when it cannot be written.
        """
        if not (counted := self.check_count()).sound:
            raise BenchError(f"the store {self.path} cannot be written: {counted.sentence}")
        with self._open() as connection:
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA synchronous=NORMAL")  # safe against a killed process; a power cut may cost rows
            prepare(connection, committed.read(self.path.parent))
            yield Writer(connection, self.path)

    def copy(self, file: Path) -> None:
        """Write all that the store holds at one moment into a new file, one without a log beside it.

        The same rows give the same bytes, wherever they lie in this store.

        Raises:
            BenchError: when there is no store, or SQLite cannot read all of it.
        """
        self.require()
        with self._open() as connection:
            connection.execute("VACUUM INTO ?", (str(file),))
            with closing(sqlite3.connect(file)) as copy, copy:
                copy.execute("UPDATE committed SET commits = 0")
                copy.execute("PRAGMA schema_version = 1")  # VACUUM counts it up from that of this store

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        """Yield a connection; raises BenchError for a store of another layout, or with other tables."""
        try:
            with closing(sqlite3.connect(_uri(self.path), timeout=30, uri=True)) as connection:
                version = layout(connection)
                if version not in (None, VERSION):
                    raise BenchError(
                        f"the store {self.path} was written in layout {version}, and this version reads layout "
                        f"{VERSION}; export it with the version that wrote it ('bench export --format csv') and import "
                        "that, or run the study into another folder"
                    )
                if version is not None and (name := strange(connection)):
                    raise BenchError(
                        f"the store {self.path} holds {printable(name, LONGEST)!r} in another form than 'bench run' "
                        f"writes it, so nothing of it is read; {RESTORE}"
                    )
                yield connection
        except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter for a damaged name in SQLite's message
            raise _refusal(self.path, error) from error

    @contextmanager
    def _read(self) -> Iterator[sqlite3.Connection]:
        """Yield a connection; one to an empty store where there is none, or where a run was killed before its tables.

        Nothing is written.
        """
        with ExitStack() as opened:
            connection = opened.enter_context(self._open()) if self.exists else None
            if connection is None or layout(connection) is None:
                connection = opened.enter_context(closing(sqlite3.connect(":memory:")))
                prepare(connection, Committed())
            connection.text_factory = decoded
            yield connection

    def require(self) -> None:
        """Raise BenchError when there is no store."""
        if not self.exists:
            raise BenchError(f"there is no {FILE} in {self.path.parent}; give the folder that 'bench run' wrote")

    def _select(self, query: str, values: Sequence[object] = ()) -> Iterator[tuple[Any, ...]]:
        with self._read() as connection:
            yield from connection.execute(query, values)

    def _of_cells(self, columns: str, shown: Mapping[int, Labels] | None, where: str) -> Iterator[Any]:
        """Yield problem, optimizer and columns of the rows of shown cells, by default of those selected."""
        labels = self.held().selected if shown is None else shown
        rows = self._select(f"SELECT cell, {columns} FROM results WHERE {where} ORDER BY cell, trial")
        return ((*labels[cell], *rest) for cell, *rest in rows if cell in labels)


def _refusal(path: Path, error: Exception) -> BenchError:
    sentence = f"the store {path} cannot be used: {printable(str(error), LONGEST)}"
    code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF  # no such table, another file
    damaged = code in (sqlite3.SQLITE_ERROR, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CORRUPT)
    return BenchError(f"{sentence}; {RESTORE if damaged else 'what it holds is kept'}")


def _uri(path: Path) -> str:
    """Return the URI with which SQLite opens a store, also in a folder that cannot be written.

    SQLite writes files beside a store even to read it. In a read-only folder it can use the index that a running or
    killed run left there; without a log the URI must declare the store immutable.
    """
    uri = path.resolve().as_uri()
    log, index = (path.with_name(f"{path.name}-{beside}") for beside in ("wal", "shm"))
    if not path.exists() or os.access(path.parent, os.W_OK):
        return uri
    return f"{uri}?mode=ro" if index.exists() or (log.exists() and log.stat().st_size) else f"{uri}?immutable=1"
