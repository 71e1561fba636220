"""A store of an older layout is read as it was written, and becomes one of this layout whole or not at all."""

import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pandas as pd
import pytest
from filelock import FileLock

from bench import BenchError, load_results
from bench.columns import STORED
from bench.storage import migrations, schema
from bench.storage.folder import Folder
from bench.storage.repair import repair
from tests.bench.storage.changes import change

OLD = Path(__file__).with_name("layout_4")
ROWS = "SELECT problem, optimizer, trial, seed, status, fun, nfev, calls, x, trace FROM trials ORDER BY 1, 2, 3"


@pytest.fixture
def folder(tmp_path):
    """A folder of layout 4, which its version wrote."""
    return Folder(shutil.copytree(OLD, tmp_path / "old"))


def layout(folder):
    return int.from_bytes(folder.store.path.read_bytes()[60:64])  # as SQLite writes PRAGMA user_version


def asked(path, query):
    with closing(sqlite3.connect(path)) as connection:
        return connection.execute(query).fetchall()


def test_every_row_is_what_it_was(folder):
    before = asked(folder.store.path, ROWS)
    counted = asked(folder.store.path, "SELECT * FROM committed")
    assert folder.store.check(structure=True).sound
    assert layout(folder) == schema.VERSION
    assert asked(folder.store.path, ROWS) == before
    assert asked(folder.store.path, "SELECT * FROM committed") == counted
    assert (len(before), sum(row[7] is not None for row in before)) == (24, 8)


def test_what_a_later_layout_added_is_unknown(folder):
    later = [column.name for column in STORED if column.since > 4 and column.frame]
    assert later == ["largest_call", "failures"]
    assert load_results(folder.path)[later].isna().all().all()


def test_the_tables_are_those_of_a_new_store(folder, tmp_path):
    with folder.store.reader():
        pass
    new = Folder(tmp_path / "new")
    new.path.mkdir()
    with new.store.writer():
        pass
    query = "SELECT type, name, sql FROM sqlite_master ORDER BY 2"
    assert asked(folder.store.path, query) == asked(new.store.path, query)


@pytest.mark.slow
def test_a_run_makes_only_the_new_trials(folder, bench_here):
    mine = ROWS.replace("FROM trials", "FROM trials WHERE optimizer = 'Hops'")  # the other's code has changed since
    before = asked(folder.store.path, mine)
    done = bench_here("run", "study.toml", "--trials", "8", "--output", ".", "--jobs", "1", cwd=folder.path)
    assert done.returncode == 0, done.stderr
    rows = asked(folder.store.path, mine.replace("nfev,", "nfev, largest_call,"))
    assert [row[:7] + row[8:] for row in rows if row[2] < 6] == before
    assert [row[7] is None for row in rows] == [row[2] < 6 for row in rows]
    assert len(rows) == 16
    assert folder.store.check(structure=True).sound


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE results SET fun = fun + 1 WHERE cell = 1 AND trial = 2",
        "UPDATE results SET status = CAST(x'ff' AS TEXT) WHERE cell = 1 AND trial = 2",
        "UPDATE results SET nfev = 'many' WHERE cell = 1 AND trial = 2",
        "UPDATE results SET trial = 7 WHERE cell = 1 AND trial = 2",
        "UPDATE results SET names = 77 WHERE cell = 1 AND trial = 2",
        "UPDATE cells SET problem = 77 WHERE id = 1",
        "DELETE FROM cells WHERE id = 1",
        "DELETE FROM results WHERE cell = 1 AND trial = 2",
        "DELETE FROM committed",
        "UPDATE environments SET record = '{}'",
    ],
)
def test_what_was_damaged_stays_damaged(folder, statement, tmp_path):
    change(folder.store.path, statement)
    found = folder.store.check()
    assert not found.sound
    assert len(found.damaged) == (6 if "cells" in statement else "results SET" in statement)
    assert found.missing == ("DELETE FROM results" in statement)
    repair(folder, 4)
    assert folder.store.check().sound


def test_a_store_with_pages_that_cannot_be_read_is_left_as_it_is(folder):
    columns = [name for _, name, *_ in asked(folder.store.path, "PRAGMA table_info(results)")]
    for more in (10, 20, 40):  # trials that do not fit their digests, on further pages
        copied = ", ".join(f"trial + {more}" if name == "trial" else name for name in columns)
        change(folder.store.path, f"INSERT INTO results SELECT {copied} FROM results")
    content = bytearray(folder.store.path.read_bytes())
    content[-4096:] = bytes(4096)
    folder.store.path.write_bytes(content)
    with pytest.raises(BenchError, match="disk image is malformed"):
        folder.store.check()
    with pytest.raises(BenchError, match="malformed; restore it from a copy, or move it away"):
        repair(folder, 4)
    assert folder.store.path.read_bytes() == content
    assert layout(folder) == 4


def test_a_store_that_cannot_be_written_is_read_from_a_copy(folder, monkeypatch):
    before, files = folder.store.path.read_bytes(), sorted(folder.path.iterdir())
    access = os.access  # the tests may run as a user who may write anywhere
    monkeypatch.setattr(os, "access", lambda path, mode: str(path) != str(folder.path) and access(path, mode))
    frame = load_results(folder.path)
    assert folder.store.path.read_bytes() == before
    assert sorted(folder.path.iterdir()) == files
    monkeypatch.undo()
    pd.testing.assert_frame_equal(load_results(folder.path), frame)
    assert layout(folder) == schema.VERSION


def test_a_store_is_left_as_it_is_while_a_run_holds_its_folder(folder):
    with FileLock(folder.path / migrations.LOCK, timeout=0):
        assert len(load_results(folder.path)) == 24
        assert layout(folder) == 4


def test_a_store_that_cannot_be_written_takes_no_trial(folder, monkeypatch):
    def full(connection, schema):
        if connection.execute("PRAGMA database_list").fetchone()[2]:  # it is no temporary one
            raise sqlite3.OperationalError("database or disk is full")
        create(connection, schema)

    before, create = folder.store.path.read_bytes(), migrations.create
    monkeypatch.setattr(migrations, "create", full)
    assert len(load_results(folder.path)) == 24
    for write in (folder.store.writer, folder.lock):
        with pytest.raises(BenchError, match="disk is full"), write():
            pytest.fail("a copy would be written")
    assert folder.store.path.read_bytes() == before


KILLED = """
import os, sys
from bench.storage import migrations
from bench.storage.store import Store
from pathlib import Path
given, made = migrations.digest, []
def digest(*values):
    made.append(1)
    return given(*values) if len(made) < 20 else os._exit(9)
migrations.digest = digest
Store(Path(sys.argv[1])).check()
"""


def test_a_kill_in_the_middle_leaves_the_older_store(folder):
    before = asked(folder.store.path, ROWS)
    assert subprocess.run([sys.executable, "-c", KILLED, folder.path], check=False).returncode == 9
    assert asked(folder.store.path, ROWS) == before
    assert layout(folder) == 4
    assert folder.store.check(structure=True).sound
    assert layout(folder) == schema.VERSION


def test_a_store_of_the_future_is_refused(folder):
    change(folder.store.path, f"PRAGMA user_version = {schema.VERSION + 1}")
    with pytest.raises(
        BenchError, match=f"was written in layout {schema.VERSION + 1}, and this version reads layout {schema.VERSION};"
    ):
        folder.store.check()


def test_what_no_version_wrote_is_refused_in_an_older_store(folder):
    change(folder.store.path, "CREATE TABLE more (x)")
    with pytest.raises(BenchError, match="holds 'more' in another form"):
        folder.store.check()
    assert layout(folder) == 4
