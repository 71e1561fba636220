"""A store of the oldest layout, which has no digests, is read and continued."""

import sqlite3
from contextlib import closing

import pandas as pd
import pytest

from bench import Results
from bench.storage.folder import Folder
from bench.storage.mend import mend
from bench.storage.schema import SCHEMA
from tests.bench.storage.changes import change
from tests.bench.storage.filled import TRIALS, add_missing, traces

OLDEST = """
CREATE TABLE environments (id INTEGER PRIMARY KEY, record TEXT NOT NULL);
CREATE TABLE cells (
    id INTEGER PRIMARY KEY, problem TEXT NOT NULL, optimizer TEXT NOT NULL, UNIQUE (problem, optimizer)
);
CREATE TABLE results (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, environment INTEGER REFERENCES environments,
    seed INTEGER NOT NULL, status TEXT NOT NULL, fun REAL, nfev INTEGER, wall_s REAL, cpu_s REAL, objective_s REAL,
    stop TEXT, outside_box INTEGER, error TEXT, x TEXT, figures TEXT,
    PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE TABLE traces (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, trace BLOB, PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE VIEW trials AS
    SELECT problem, optimizer, trial, environment, seed, status, fun, nfev, wall_s, cpu_s, objective_s, stop,
           outside_box, error, x, figures, trace
    FROM results JOIN cells ON cells.id = results.cell LEFT JOIN traces USING (cell, trial);
PRAGMA user_version = 1;
"""
COPIED = {
    "environments": "id, record",
    "cells": "*",
    "results": "cell, trial, environment, seed, status, fun, nfev, wall_s, cpu_s, objective_s, stop, outside_box, "
    "error, x, figures",
    "traces": "*",
}


@pytest.fixture
def old(filled, tmp_path):
    """The study's folder as the oldest version wrote it, without the last ten trials of each cell."""
    folder = Folder(tmp_path / "old")
    folder.path.mkdir()
    (folder.path / "study.toml").write_bytes((filled.path / "study.toml").read_bytes())
    with closing(sqlite3.connect(folder.store.path)) as connection:
        connection.executescript(OLDEST)
        connection.execute("ATTACH ? AS filled", (str(filled.store.path),))
        for table, columns in COPIED.items():
            some = " WHERE trial < 20" if table in ("results", "traces") else ""
            connection.execute(f"INSERT INTO {table} SELECT {columns} FROM filled.{table}{some}")
        connection.commit()
    return folder


def test_a_schema_that_changes_has_another_version():
    """Nothing else distinguishes an old store from a new one."""
    assert "PRAGMA user_version = 2\n" in SCHEMA


def test_it_is_read_as_it_is(old, filled):
    before = old.store.path.read_bytes()
    results, expected = Results(old.path), Results(filled.path)
    frame = expected.frame[expected.frame["trial"] < 20].reset_index(drop=True)
    pd.testing.assert_frame_equal(results.frame, frame, check_exact=True)
    assert traces(results) == {key: each for key, each in traces(expected).items() if key[2] < 20}
    assert results.environments == expected.environments
    assert not results.damage
    assert results.stores[0].sentence == (
        "a change of the 80 trials cannot be noticed, as an older version stored them without digests; the next "
        "'bench run' adds digests"
    )
    assert old.store.path.read_bytes() == before


def test_the_next_run_gives_its_trials_digests_and_continues(old, filled):
    assert mend(old, TRIALS).startswith("the 80 trials of ")
    assert mend(old, TRIALS) == ""
    assert old.store.check().sentence == "all 80 trials are as they were written"
    add_missing(old)
    results, expected = Results(old.path), Results(filled.path)
    pd.testing.assert_frame_equal(results.frame, expected.frame, check_exact=True)
    assert traces(results) == traces(expected)
    change(old.store.path, "UPDATE results SET fun = 0 WHERE trial IN (1, 25)")
    assert len(old.store.check().damaged) == 8
    with closing(sqlite3.connect(old.store.path)) as connection:
        assert connection.execute("SELECT count(*) FROM trials").fetchone() == (120,)


def test_an_upgrade_that_ends_in_an_error_leaves_the_old_store(old, monkeypatch):
    change(old.store.path, "CREATE TABLE digest_key (other TEXT)")
    before = old.store.path.read_bytes()
    with pytest.raises(ValueError, match="already exists"), old.store.writer():
        pass
    with closing(sqlite3.connect(old.store.path)) as connection:
        columns = {row[1] for row in connection.execute("PRAGMA table_info(results)")}
    assert "digest" not in columns
    assert before
