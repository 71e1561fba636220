"""The tables of a study's store."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from functools import cache

from bench.storage.committed import Committed
from bench.storage.rows import NAMES, VALUES
from bench.trial.columns import STORED

VERSION = 7
"""The layout of stores; others are refused."""

SELECTED = "results JOIN selected ON selected.cell = results.cell LEFT JOIN names ON names.id = results.names"
"""The SQL tables of the trials that the last study selects, under the labels that it shows."""

_KINDS = {int: "INTEGER", float: "REAL", str: "TEXT", bytes: "BLOB"}
_RULES = {
    "environment": " REFERENCES environments", "inputs": " REFERENCES inputs", "status": " NOT NULL",
}  # fmt: skip


@cache
def schema() -> str:
    """Return the statements that make the tables.

    A trace stands last, behind what most readers ask for, as it may take ten times the space of the rest.
    """
    definitions = [f"{column.name} {_KINDS[column.kind]}{_RULES.get(column.name, '')}" for column in STORED]
    return f"""
CREATE TABLE committed (commits INTEGER NOT NULL, trials INTEGER NOT NULL);
CREATE TABLE environments (id INTEGER PRIMARY KEY, record TEXT NOT NULL, digest BLOB);
CREATE TABLE inputs (id INTEGER PRIMARY KEY, record TEXT NOT NULL, digest BLOB);
CREATE TABLE history (id INTEGER PRIMARY KEY, record TEXT NOT NULL, digest BLOB);
CREATE TABLE problems (id INTEGER PRIMARY KEY, record TEXT NOT NULL UNIQUE);
CREATE TABLE optimizers (id INTEGER PRIMARY KEY, record TEXT NOT NULL UNIQUE);
CREATE TABLE cells (
    id INTEGER PRIMARY KEY, problem INTEGER NOT NULL REFERENCES problems,
    optimizer INTEGER NOT NULL REFERENCES optimizers, evaluations INTEGER NOT NULL, seed INTEGER NOT NULL,
    UNIQUE (problem, optimizer, evaluations, seed)
);
CREATE TABLE study (identity TEXT NOT NULL, digest BLOB NOT NULL);
CREATE TABLE selected (
    cell INTEGER PRIMARY KEY REFERENCES cells, problem TEXT NOT NULL, optimizer TEXT NOT NULL,
    UNIQUE (problem, optimizer)
);
CREATE TABLE names (
    id INTEGER PRIMARY KEY, {", ".join(f"{name} TEXT NOT NULL" for name in NAMES)}, UNIQUE ({", ".join(NAMES)})
);
CREATE TABLE results (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, digest BLOB, names INTEGER REFERENCES names,
    {", ".join(definitions)}, PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE VIEW trials AS
    SELECT problem, optimizer, trial, {", ".join(NAMES)}, {", ".join(VALUES)}
    FROM {SELECTED};
PRAGMA user_version = {VERSION}
"""


def layout(connection: sqlite3.Connection) -> int | None:
    """Return the layout of a store, None of one without tables."""
    empty = not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    return None if empty else int(connection.execute("PRAGMA user_version").fetchone()[0])


def strange(connection: sqlite3.Connection) -> str:
    """Return the name of what a store has and its layout has not: a table, an index, a view or a trigger; or "".

    A stranger's view may have no end, and triggers and generated columns compute whenever they are read or written.
    What is missing is found where it is read.
    """
    foreign = {*connection.execute(_STRUCTURE)} - _ours()
    return min((name.decode(errors="replace") for _, name, _ in foreign), default="")


_STRUCTURE = "SELECT CAST(type AS BLOB), CAST(name AS BLOB), CAST(sql AS BLOB) FROM sqlite_master"


@cache
def _ours() -> frozenset[tuple[bytes, bytes, bytes | None]]:
    with closing(sqlite3.connect(":memory:")) as connection:
        create(connection, schema())
        return frozenset(connection.execute(_STRUCTURE))


def create(connection: sqlite3.Connection, statements: str) -> None:
    """Make tables in the transaction that is open, which no script of SQLite leaves open."""
    for statement in statements.split(";"):
        connection.execute(statement)


def prepare(connection: sqlite3.Connection, begun: Committed) -> None:
    """Make the tables of a new store, all or nothing, whose commits are counted from those ``begun`` before."""
    if layout(connection) is not None:
        return
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        create(connection, schema())
        connection.execute("INSERT INTO committed VALUES (?, 0)", (begun.commits,))
