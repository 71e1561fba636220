"""After damage a run makes the lost trials again, and only these."""

import random
import shutil
import sqlite3
from contextlib import closing

import pandas as pd
import pytest

from bench import BenchError, Results, Study, load_results, run
from bench.execution.runner import plan
from bench.storage.folder import Folder
from bench.storage.repair import ASIDE, repair
from tests.bench.storage.changes import change
from tests.bench.storage.filled import RECORD, TRIALS, add_missing, assert_repaired, damage_of, traces


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE environments SET record = replace(record, 'here', 'there')", "UPDATE environments SET record = 7",
        "UPDATE environments SET record = '[[['", "UPDATE environments SET digest = NULL", "DELETE FROM environments",
    ],
)  # fmt: skip
def test_a_changed_record_of_an_environment_is_named_and_its_trials_kept(statement, spoilt, filled):
    change(spoilt.store.path, statement)
    found = spoilt.store.check()
    assert found.environments == [1]
    assert found.sentence == "the record of environment 1 is damaged"
    assert len(Results(spoilt.path).frame) == 120
    repair(spoilt, TRIALS)
    assert spoilt.store.check().trials == 120
    if "DELETE" not in statement and "digest" not in statement:
        assert spoilt.environments() == [RECORD]  # environment.json holds a copy that fits its digest
    else:
        assert spoilt.environments() == []
        assert all(row["environment"] is None for row in spoilt.store.rows())
    assert spoilt.store.check().sound


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
    "seeds", [range(20), pytest.param(range(20, 200), marks=pytest.mark.slow)], ids=["few", "many"]
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
        try:
            repaired = repair(spoilt, TRIALS)
        except BenchError:  # its sentence says to move the store away and to run the study again
            spoilt.store.path.rename(tmp_path / "moved-away")
            repaired = repair(spoilt, TRIALS)  # as a run does
        assert repaired or not said, seed
        spoilt.claim(Study.load(spoilt.path / "study.toml"))
        add_missing(spoilt)
        again = Results(spoilt.path)
        assert not again.damage, seed
        pd.testing.assert_frame_equal(again.frame, frame, check_exact=True)
        assert traces(again) == known, seed
    assert noticed > len(seeds) / 5  # the rest hit unused space


def page(store, number):
    """Return a page of a store's file, counted from 1."""
    return store.path.read_bytes()[4096 * (number - 1) : 4096 * number]


def leaves(store):
    """Return the numbers of the pages that hold rows of the table of results."""
    with closing(sqlite3.connect(store.path)) as connection:
        (root,) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'results'").fetchone()
    inner = page(store, root)
    assert inner[0] == 2  # an index's interior page
    cells = [int.from_bytes(inner[place : place + 2], "big") for place in range(12, 12 + 2 * inner[4], 2)]
    return [int.from_bytes(inner[place : place + 4], "big") for place in (*cells, 8)]


def test_what_can_be_read_of_a_damaged_file_is_kept(filled, spoilt):
    content = bytearray(spoilt.store.path.read_bytes())
    lost = leaves(spoilt.store)[2]
    content[4096 * (lost - 1) : 4096 * lost] = bytes(4096)
    spoilt.store.path.write_bytes(content)
    with pytest.raises(BenchError, match="disk image is malformed; 'bench run' into this folder keeps the trials that"):
        Results(spoilt.path).frame  # noqa: B018
    said = repair(spoilt, TRIALS)
    assert "the structure of the file is damaged" in said
    kept = spoilt.store.check(structure=True)
    assert kept.sound
    assert 80 < kept.trials < 120  # one page of several
    assert f"{kept.trials} sound trials are kept, and the damaged store is now {ASIDE}" in said
    assert (spoilt.path / ASIDE).read_bytes() == content
    assert_repaired(spoilt, filled)


@pytest.mark.parametrize(("table", "kept"), [("selected", 120), ("study", 120), ("problems", 0)])
def test_cells_that_cannot_be_read_cost_no_more_than_they_must(table, kept, filled, spoilt):
    with closing(sqlite3.connect(spoilt.store.path)) as connection:
        (root,) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = ?", (table,)).fetchone()
    content = bytearray(spoilt.store.path.read_bytes())
    content[4096 * (root - 1) : 4096 * root] = bytes(4096)
    spoilt.store.path.write_bytes(content)
    assert not spoilt.untrusted  # which a run asks first
    assert f"{kept} sound trials are kept" in repair(spoilt, TRIALS)
    assert_repaired(spoilt, filled)


def test_a_store_that_was_cut_short_keeps_its_beginning(filled, spoilt):
    content = spoilt.store.path.read_bytes()
    spoilt.store.path.write_bytes(content[: len(content) * 5 // 6])
    repair(spoilt, TRIALS)
    assert 20 < spoilt.store.check().trials < 120
    assert_repaired(spoilt, filled)


@pytest.mark.parametrize("hole", [slice(0, 4096), slice(100, 4096), slice(4096, None)])
def test_a_store_beyond_repair_is_one_sentence_and_stays(hole, spoilt):
    content = bytearray(spoilt.store.path.read_bytes())
    content[hole] = bytes(len(content[hole]))
    spoilt.store.path.write_bytes(content)
    with pytest.raises(BenchError, match="restore it from a copy, or move it away and run the study again"):
        repair(spoilt, TRIALS)
    assert spoilt.store.path.read_bytes() == content
    assert not (spoilt.path / ASIDE).exists()


def test_rows_that_sqlite_cannot_find_are_not_given_up(spoilt):
    content = spoilt.store.path.read_bytes()
    spoilt.store.path.write_bytes(content.replace(b"CREATE TABLE results", b"CREATE TABLE r\xfesults"))
    with pytest.raises(BenchError, match="restore it from a copy, or move it away and run the study again"):
        repair(spoilt, TRIALS)
    spoilt.store.path.write_bytes(content.replace(b"CREATE VIEW trials", b"CREATE VXEW trials"))
    assert "120 sound trials are kept" in repair(spoilt, TRIALS)


def test_a_sound_store_stays_as_it_is(spoilt):
    before = spoilt.store.path.read_bytes()
    assert repair(spoilt, TRIALS) == ""
    assert spoilt.store.path.read_bytes() == before
    assert spoilt.noted("store.json")["sentence"] == "all 120 trials are as they were written"


def test_a_run_makes_damaged_trials_again(small_study, tmp_path):
    folder = Folder(tmp_path / "out")
    run(small_study, folder.path, jobs=1)
    before = load_results(folder.path)
    change(
        folder.store.path,
        "UPDATE results SET fun = 0 WHERE trial = 1",
        "UPDATE results SET trace = NULL WHERE trial = 2",
    )
    assert len(folder.store.check().damaged) == 12
    assert len([*plan(small_study, folder.path).missing()]) == 12
    plans, made = [], []
    run(small_study, folder.path, jobs=1, on_plan=plans.append, on_trial=lambda trial, _: made.append(trial.key))
    assert len(made) == len(set(made)) == 12
    assert plans[0].notes[0].startswith("12 of 18 trials are damaged (")
    times = ["wall_s", "cpu_s", "objective_s"]
    pd.testing.assert_frame_equal(
        load_results(folder.path).drop(columns=times), before.drop(columns=times), check_exact=True
    )
