"""The tables of a study's store, and the upgrade of a store that an older version of the layout wrote."""

from __future__ import annotations

import sqlite3

from bench.storage.digests import MEASURED, SEAL, Digests, new_key

VERSION = 2
OLDEST = 1  # which has no digests

KEY = ("problem", "optimizer", "trial")

# Traces have a table of their own: they take ten times the space of the rest, and most readers need none.
SCHEMA = f"""
CREATE TABLE digest_key (key BLOB NOT NULL, digest BLOB NOT NULL);
CREATE TABLE environments (id INTEGER PRIMARY KEY, record TEXT NOT NULL, digest BLOB);
CREATE TABLE cells (
    id INTEGER PRIMARY KEY, problem TEXT NOT NULL, optimizer TEXT NOT NULL, UNIQUE (problem, optimizer)
);
CREATE TABLE results (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, environment INTEGER REFERENCES environments,
    seed INTEGER, status TEXT NOT NULL, fun REAL, nfev INTEGER, wall_s REAL, cpu_s REAL, objective_s REAL,
    stop TEXT, outside_box INTEGER, error TEXT, x TEXT, figures TEXT, digest BLOB,
    PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE TABLE traces (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, trace BLOB, PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE VIEW trials AS
    SELECT problem, optimizer, trial, {", ".join(MEASURED)}, trace
    FROM results JOIN cells ON cells.id = results.cell LEFT JOIN traces USING (cell, trial);
PRAGMA user_version = {VERSION}
"""

_UPGRADE = f"""
CREATE TABLE digest_key (key BLOB NOT NULL, digest BLOB NOT NULL);
ALTER TABLE environments ADD COLUMN digest BLOB;
ALTER TABLE results ADD COLUMN digest BLOB;
PRAGMA user_version = {VERSION}
"""


def has_digests(connection: sqlite3.Connection) -> bool:
    """Return whether the store has digests, which one of the oldest layout lacks, whatever it says of its layout."""
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    query = "SELECT count(*) FROM sqlite_master WHERE name = 'digest_key'"
    return version > OLDEST or bool(connection.execute(query).fetchone()[0])


def prepare(connection: sqlite3.Connection) -> Digests:
    """Make the tables of a new store, or give an older one digests, all or nothing; return the digests to write."""
    version = connection.execute("PRAGMA user_version").fetchone()[0]
    with connection:
        if version != VERSION:
            connection.execute("BEGIN IMMEDIATE")
            for statement in (_UPGRADE if version else SCHEMA).split(";"):
                connection.execute(statement)
            connection.execute("INSERT INTO digest_key VALUES (?, ?)", new_key())
        digests = Digests(connection)
        if version == OLDEST:
            connection.execute(SEAL)
            for number, record in connection.execute("SELECT id, CAST(record AS BLOB) FROM environments").fetchall():
                sealed = digests.record(number, record), number
                connection.execute("UPDATE environments SET digest = ? WHERE id = ?", sealed)
    return digests
