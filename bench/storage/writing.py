"""Write the rows of a store."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bench.columns import Row
from bench.errors import BenchError
from bench.storage import committed
from bench.storage.committed import Committed
from bench.storage.reading import record_digest
from bench.storage.rows import NAMES, VALUES, binding, digest, typed
from bench.storage.schema import ONE, found
from bench.trial import Trial

_INTO = ("cell", "trial", "digest", "names", *VALUES)
_INSERT = f"INSERT INTO results ({', '.join(_INTO)}) VALUES ({', '.join('?' * len(_INTO))})"
_TWICE = "SQLITE_CONSTRAINT_PRIMARYKEY", "SQLITE_CONSTRAINT_UNIQUE"  # of a row that is there already
_NUMBERED = {"cells": ("problem", "optimizer"), "names": NAMES}
"""The tables of texts that rows refer to by number, and their columns."""


class Writer:
    """The only writer of an open store: adds and removes rows.

    Args:
        connection: to the store.
        path: of the store.
        noted: whether what is committed is noted beside it, as it is unless the store is not in its place yet.
    """

    def __init__(self, connection: sqlite3.Connection, path: Path, *, noted: bool = True) -> None:
        self._connection, self._path, self._noted = connection, path, noted
        self._file = _identity(path)
        self._committed, self._more = Committed(), 0  # what was committed, and rows added since then
        self._numbers: dict[str, dict[tuple[Any, ...], int]] = {}
        self._read()
        self._note()

    def add(self, trial: Trial, row: Row, environment: int | None = None) -> None:
        """Commit one trial's row, as :func:`bench.trial.finished` returns it; missing columns are stored as NULL.

        It replaces a failed row of the same trial, but never a finished one.
        """
        with self.transaction():
            self.put(row | trial.columns | {"environment": environment})

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Commit all that is written in this context, or nothing of it.

        Raises:
            BenchError: where another program has removed or replaced the store's file, or writes to it, too.
        """
        try:
            with self._connection:
                yield
                self._committed = Committed(self._committed.commits + 1, self._committed.trials + self._more)
                self._connection.execute("UPDATE committed SET commits = ?, trials = ?", self._committed)
                self._more = 0
        except BaseException as error:
            self._read()  # without the cells and names of rows that were not committed
            if getattr(error, "sqlite_errorname", "") not in _TWICE:
                raise
            raise BenchError(
                f"another run writes to the store {self._path}, as where .lock was removed from its folder; what it "
                "holds is kept: wait for the end of the other run, and run the same command again"
            ) from error
        if _identity(self._path) != self._file:
            raise BenchError(
                f"the store {self._path} was removed or replaced while it was written, and its last trials are lost; "
                "run the same command again to make them"
            )
        self._note()

    def put(self, row: Mapping[str, Any]) -> None:
        """Add a row as :meth:`bench.storage.store.Store.rows` yields it, within :meth:`transaction`.

        Raises:
            ValueError: for a column that the store does not have.
        """
        values = typed(row)
        texts = [None if row.get(name) is None else str(row[name]) for name in ("problem", "optimizer", *NAMES)]
        cell = self._number("cells", *texts[:2])
        names = self._number("names", *texts[2:]) if texts[2] is not None else None
        bound = binding(*(text if text is None else text.encode() for text in texts))
        hashed = [value.encode() if isinstance(value, str) else value for value in values]
        noted = digest(bound, (row["trial"], *hashed))
        replaced = self._connection.execute(
            "DELETE FROM results WHERE cell = ? AND trial = ? AND status != 'ok'", (cell, row["trial"])
        )
        self._connection.execute(_INSERT, (cell, row["trial"], noted, names, *values))
        self._more += 1 - replaced.rowcount

    def find(self, problem: str, optimizer: str, trial: int) -> dict[str, Any] | None:
        """Return the row of one trial, as :meth:`bench.storage.store.Store.rows` yields it, or None."""
        return next(found(self._connection, ONE, (problem, optimizer, trial)), None)

    def environment(self, record: Mapping[str, Any]) -> int:
        """Commit an environment's record and return its number; equal records have one number."""
        text = json.dumps(record)
        noted = self._connection.execute("SELECT id FROM environments WHERE record = ?", (text,)).fetchone()
        if noted is not None:
            return int(noted[0])
        with self.transaction():
            made = self._connection.execute("INSERT INTO environments (record) VALUES (?)", (text,))
            number = int(made.lastrowid or 0)
            self._record(number, text)
        return number

    def change(self, number: int, record: Mapping[str, Any]) -> None:
        """Commit a changed record of an environment."""
        with self.transaction():
            self._record(number, json.dumps(record))

    def remove(self, problems: list[str], optimizers: list[str], *, failed_only: bool = False) -> int:
        """Remove the rows of all cells of these problems and optimizers, or only failed rows; return their number."""
        cells = [(self._numbers["cells"].get((problem, label)),) for problem in problems for label in optimizers]
        with self.transaction():
            condition = " AND status != 'ok'" if failed_only else ""
            done = self._connection.executemany(f"DELETE FROM results WHERE cell = ?{condition}", cells)
            self._more -= done.rowcount
        return int(done.rowcount)

    def _note(self) -> None:
        if self._noted:
            committed.write(self._path.parent, self._committed)

    def _record(self, number: int, text: str) -> None:
        values = text, record_digest(number, text.encode()), number
        self._connection.execute("UPDATE environments SET record = ?, digest = ? WHERE id = ?", values)

    def _read(self) -> None:
        """Read the numbers of cells and names, and what was committed."""
        self._more = 0
        self._committed = Committed(*self._connection.execute("SELECT commits, trials FROM committed").fetchone())
        self._numbers = {
            table: {
                tuple(texts): int(number)
                for number, *texts in self._connection.execute(f"SELECT id, {', '.join(columns)} FROM {table}")
            }
            for table, columns in _NUMBERED.items()
        }

    def _number(self, table: str, *texts: str | None) -> int:
        """Return the number of a cell or of names, which are added where they are new."""
        numbers = self._numbers[table]
        if texts not in numbers:
            made = self._connection.execute(f"INSERT INTO {table} ({', '.join(_NUMBERED[table])}) VALUES (?, ?)", texts)
            numbers[texts] = int(made.lastrowid or 0)
        return numbers[texts]


def _identity(path: Path) -> tuple[int, int] | None:
    """Return what distinguishes a file from another one in its place, None where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino
