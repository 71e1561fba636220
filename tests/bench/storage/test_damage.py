"""Damage is named, nothing is read beside it, and no run adds to it."""

import pickle
import random
import shutil
import sqlite3
from contextlib import closing, suppress

import pytest

from bench import BenchError, Results, load_results, run
from bench.storage.folder import Folder
from bench.storage.rows import VALUES
from bench.storage.store import Store
from tests.bench.installed.testing_calls import Bomb
from tests.bench.storage.changes import change
from tests.bench.storage.filled import damage_of, traces


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE environments SET record = replace(record, 'here', 'there')", "UPDATE environments SET record = 7",
        "UPDATE environments SET record = '[[['", "UPDATE environments SET digest = NULL", "DELETE FROM environments",
    ],
)  # fmt: skip
def test_a_changed_record_of_an_environment_is_named(statement, spoilt):
    change(spoilt.store.path, statement)
    assert spoilt.store.check().sentence == "the record of environment 1 is damaged"
    for read_by in (spoilt.require_sound, lambda: load_results(spoilt.path)):
        with pytest.raises(BenchError, match=r"record of environment 1 is damaged; restore trials\.sqlite from a copy"):
            read_by()


def damaged_copy(filled, folder, seed):
    """Write sixteen random bytes to a random place of a copy of a store."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(filled.path, folder)
    spoilt, rng = Folder(folder), random.Random(seed)
    content = bytearray(spoilt.store.path.read_bytes())
    place = rng.randrange(len(content) - 16)
    content[place : place + 16] = rng.randbytes(16)
    spoilt.store.path.write_bytes(content)
    return spoilt


@pytest.mark.parametrize(
    "seeds", [range(10), pytest.param(range(10, 200), marks=pytest.mark.slow)], ids=["few", "many"]
)
def test_sixteen_random_bytes_anywhere_are_noticed_or_change_nothing(seeds, filled, tmp_path):
    with closing(sqlite3.connect(filled.store.path)) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    original = Results(filled.path)
    frame, known = original.frame, traces(original)
    noticed = 0
    for seed in seeds:
        spoilt = damaged_copy(filled, tmp_path / "copy", seed)
        said = damage_of(spoilt, original, frame, known)
        noticed += bool(said)
        if said:
            with pytest.raises(BenchError):
                spoilt.require_sound()
    assert noticed >= len(seeds) / 5  # the rest hit unused space


READERS = (lambda path: list(Store(path).rows()), lambda path: Results(path).frame, lambda path: Results(path).traces)


def test_nothing_is_unpickled_from_a_store(small_study, tmp_path):
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    mark = tmp_path / "unpickled"
    bomb = pickle.dumps(Bomb(str(mark)))
    for column in VALUES:
        with sqlite3.connect(tmp_path / "out" / "trials.sqlite") as connection:
            kept = connection.execute(f"SELECT {column} FROM results LIMIT 1").fetchone()[0]
            connection.execute(f"UPDATE results SET {column} = ? WHERE {column} = ?", (bomb, kept))
        for read in READERS:
            with suppress(BenchError, ValueError, TypeError):  # a damaged store may be refused
                read(tmp_path / "out")
        assert not mark.exists()
    pickle.loads(bomb).close()
    assert mark.exists()
