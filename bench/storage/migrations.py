"""Bring a store of an older layout to this one, whole or not at all.

Layouts differ in the columns of ``results`` alone, which :data:`bench.columns.STORED` dates by ``since``. Trials of an
older layout lack the others.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from bench.storage.cells import read
from bench.storage.reading import bound
from bench.storage.rows import TEXTS, VALUES, digest
from bench.storage.schema import OLDEST, VERSION, create, layout, schema, values_of

LOCK = ".lock"
"""The file that a run locks in its folder."""


@contextmanager
def current(connection: sqlite3.Connection, path: Path, *, writing: bool) -> Iterator[sqlite3.Connection]:
    """Yield a connection to an open store in this layout: itself, brought to it where need be, or a temporary copy.

    A store is read from a copy where it cannot be written, and while a run writes to its folder.

    Args:
        connection: to the store.
        path: of the store.
        writing: whether it is to be written by whoever has locked its folder; then it is no copy.

    Raises:
        sqlite3.Error: where the store cannot be read, or not be written as it must.
    """
    if writing:
        _migrate(connection)
    if _is_older(connection) and not _migrated(connection, path.parent):
        with closing(sqlite3.connect("")) as copy:  # a file that SQLite removes
            connection.backup(copy)
            _migrate(copy)
            yield copy
    else:
        yield connection


def _is_older(connection: sqlite3.Connection) -> bool:
    return layout(connection) in range(OLDEST, VERSION)


def _migrated(connection: sqlite3.Connection, folder: Path) -> bool:
    """Bring the open store of a folder to this layout where no run writes there; return whether that was possible."""
    with suppress(OSError, NotImplementedError, Timeout, sqlite3.OperationalError):  # such as a disk that is full
        if os.access(folder, os.W_OK):
            with FileLock(folder / LOCK, timeout=0):
                _migrate(connection)
                return True
    return False


def _migrate(connection: sqlite3.Connection) -> None:
    """Bring an open store to this layout, in one transaction; a kill leaves the older store or the new one."""
    if not _is_older(connection):
        return
    factory, connection.text_factory = connection.text_factory, bytes  # damage may leave texts that are no UTF-8
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        if _is_older(connection):  # else another process was first
            older = values_of(layout(connection))
            connection.execute("DROP VIEW IF EXISTS trials")
            connection.execute("ALTER TABLE results RENAME TO older")
            create(connection, ";".join(part for part in schema().split(";") if "results" in part or "PRAGMA" in part))
            places = ", ".join("CAST(? AS TEXT)" if name in TEXTS else "?" for name in VALUES)
            connection.executemany(f"INSERT INTO results VALUES (?, ?, ?, ?, {places})", _rows(connection, older))
            connection.execute("DROP TABLE older")
    connection.text_factory = factory
    with suppress(sqlite3.OperationalError):
        connection.execute("VACUUM")  # else the file keeps the space of the older table


def _rows(connection: sqlite3.Connection, older: tuple[str, ...]) -> Iterator[tuple[Any, ...]]:
    """Yield the rows in this layout, texts as UTF-8; a row that does not fit its digest gets none: it stays damaged."""
    cells = read(connection, rescue=True).all
    names = {number: texts for number, *texts in connection.execute("SELECT * FROM names")}
    for noted, cell, number, trial, *values in connection.execute(
        f"SELECT digest, cell, names, trial, {', '.join(older)} FROM older ORDER BY cell, trial"
    ):
        known = dict(zip(older, values, strict=True))
        moved, before = [known.get(name) for name in VALUES], bound(cells, names, cell, number)
        sound = before is not None and digest(before, (trial, *values)) == noted
        yield cell, trial, digest(before or b"", (trial, *moved)) if sound else None, number, *moved
