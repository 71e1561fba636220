"""A stored trial that was changed is noticed, whoever changed what of it."""

import subprocess
from marshal import dumps

import pandas as pd
import pytest

from bench import BenchError, Results, load_results
from bench.storage import digests
from bench.storage.digests import FORMAT
from bench.storage.folder import Folder
from bench.storage.mend import mend
from tests.bench.storage.changes import SCATTER, change
from tests.bench.storage.filled import OPTIMIZERS, TRIALS, add_missing, assert_mended

ONE = f"cell = {SCATTER} AND trial = 7"
EARLY = "(SELECT id FROM cells WHERE problem = 'sphere-2' AND optimizer = 'early')"
CHANGED = {("sphere-2", "scatter", 7)}
TEXTS = ("status", "stop", "error", "x", "figures")


def test_the_bytes_that_are_hashed_are_the_same_in_every_version_of_python():
    """Stores move between versions; marshal promises nothing, so this test holds its format 2."""
    row = (7, None, 2**62, b"ok", 0.1, -1, 2**31, "aä")
    expected = "2808000000 6907000000 4e 6c050000000000000000000000 0400 73020000006f6b 679a9999999999b93f 69ffffffff"
    assert dumps(row, FORMAT) == bytes.fromhex(f"{expected} 6c03000000000000000200 750300000061c3a4")


def test_a_store_as_it_was_written_is_sound(filled):
    found = filled.store.check(structure=True)
    assert (found.sound, found.trials) == (True, 120)
    assert found.sentence == "all 120 trials are as they were written"
    assert len(list(filled.store.sound_rows(found))) == 120


@pytest.mark.parametrize(
    "statement",
    [
        *(f"UPDATE results SET {name} = {name} + 1" for name in ("seed", "nfev", "outside_box", "environment")),
        *(f"UPDATE results SET {name} = {name} * (1 + 1e-15)" for name in ("fun", "wall_s", "cpu_s", "objective_s")),
        *(f"UPDATE results SET {name} = coalesce({name}, '') || ' '" for name in TEXTS),
        *(f"UPDATE results SET {name} = CAST(coalesce({name}, '') AS BLOB)" for name in TEXTS),
        *(f"UPDATE results SET {name} = CAST(x'ff' AS TEXT)" for name in ("x", "error", "fun", "nfev", "digest")),
        *(f"UPDATE results SET {name} = NULL" for name in ("fun", "x", "digest")),
        "UPDATE results SET x = replace(x, ' -0.0', ' 0.0')",
        "UPDATE results SET status = 'failed'",
        "UPDATE results SET digest = x'0011223344556677'",
        "UPDATE results SET digest = (SELECT digest FROM results WHERE trial = 8)",
        "UPDATE traces SET trace = x'' || trace || x'00'",
        "UPDATE traces SET trace = CAST(trace AS TEXT)",
        "UPDATE traces SET trace = NULL",
        "DELETE FROM traces",
    ],
)
def test_a_changed_row_is_named(statement, spoilt, filled):
    change(spoilt.store.path, f"{statement} WHERE {ONE}")
    found = spoilt.store.check()
    assert {*found.damaged} == CHANGED
    assert found.sentence == (
        "1 of 120 trials are damaged (scatter on sphere-2, trial 7); damaged trials count as missing, and 'bench run' "
        "makes them again"
    )
    results = Results(spoilt.path)
    expected = Results(filled.path).frame
    gone = (expected["problem"] == "sphere-2") & (expected["optimizer"] == "scatter") & (expected["trial"] == 7)
    pd.testing.assert_frame_equal(results.frame, expected[~gone].reset_index(drop=True), check_exact=True)
    assert set(results.traces) == set(Results(filled.path).traces) - CHANGED
    with pytest.warns(UserWarning, match="scatter on sphere-2, trial 7"):
        assert len(load_results(spoilt.path)) == 119
    assert_mended(spoilt, filled)


SWAP = "SELECT {what} FROM results WHERE cell = " + SCATTER + " AND trial = {trial}"
OTHERS = {
    "a row replaced by plain SQL": (
        [f"CREATE TEMP TABLE row AS SELECT * FROM results WHERE {ONE}", f"DELETE FROM results WHERE {ONE}",
         "UPDATE row SET fun = 0", "INSERT INTO results SELECT * FROM row"],
        CHANGED,
    ),
    "two trials that changed places": (
        [f"UPDATE {table} SET trial = {new} WHERE cell = {SCATTER} AND trial = {old}"
         for table in ("results", "traces") for old, new in ((7, -1), (8, 7), (-1, 8))],
        {("sphere-2", "scatter", 7), ("sphere-2", "scatter", 8)},
    ),
    "a trial moved to another number": (
        [f"DELETE FROM {table} WHERE cell = {SCATTER} AND trial = 8" for table in ("results", "traces")]
        + [f"UPDATE {table} SET trial = 8 WHERE {ONE}" for table in ("results", "traces")],
        {("sphere-2", "scatter", 8)},
    ),
    "a trial moved to another optimizer": (
        [f"DELETE FROM {table} WHERE cell = {EARLY} AND trial = 7" for table in ("results", "traces")]
        + [f"UPDATE {table} SET cell = {EARLY} WHERE {ONE}" for table in ("results", "traces")],
        {("sphere-2", "early", 7)},
    ),
    "optimizers that changed their labels": (
        ["UPDATE cells SET optimizer = 'x' WHERE problem = 'sphere-2' AND optimizer = 'scatter'",
         "UPDATE cells SET optimizer = 'scatter' WHERE problem = 'sphere-2' AND optimizer = 'early'",
         "UPDATE cells SET optimizer = 'early' WHERE optimizer = 'x'"],
        {("sphere-2", optimizer, trial) for optimizer in OPTIMIZERS for trial in range(TRIALS)},
    ),
    "a label of no optimizer": (
        ["UPDATE cells SET optimizer = 'gwo' WHERE problem = 'sphere-2' AND optimizer = 'scatter'"],
        {("sphere-2", "gwo", trial) for trial in range(TRIALS)},
    ),
    "a cell removed": (
        ["DELETE FROM cells WHERE problem = 'sphere-2' AND optimizer = 'scatter'"],
        {("an unknown problem", "an unknown optimizer", trial) for trial in range(TRIALS)},
    ),
    "a trial beyond all numbers": (
        [f"UPDATE results SET trial = {2**62} WHERE {ONE}"],
        {("sphere-2", "scatter", 2**62), ("sphere-2", "scatter", 7)},  # the second has a trace and no row
    ),
    "a row removed, but not its trace": ([f"DELETE FROM results WHERE {ONE}"], CHANGED),
}  # fmt: skip


@pytest.mark.parametrize("what", OTHERS)
def test_what_another_program_did_is_named(what, spoilt, filled):
    statements, damaged = OTHERS[what]
    change(spoilt.store.path, *statements)
    assert {*spoilt.store.check().damaged} == damaged
    assert_mended(spoilt, filled)


def test_a_trial_that_was_removed_filled_is_missing(spoilt, filled):
    change(spoilt.store.path, *(f"DELETE FROM {table} WHERE {ONE}" for table in ("results", "traces")))
    found = spoilt.store.check()
    assert (found.sound, found.trials) == (True, 119)
    assert_mended(spoilt, filled)


def test_a_damaged_key_is_not_taken_for_damage_of_all_rows(spoilt):
    before = spoilt.store.path.read_bytes()
    for statement in ("UPDATE digest_key SET key = x'00'", "DELETE FROM digest_key", "DROP TABLE digest_key"):
        spoilt.store.path.write_bytes(before)
        change(spoilt.store.path, statement)
        with pytest.raises(BenchError, match="restore it from a copy, or move it away and run the study again"):
            spoilt.store.check()
        with pytest.raises(BenchError, match="restore it from a copy"):
            mend(spoilt, TRIALS)
    assert spoilt.store.path.exists()


def test_a_store_cannot_pretend_to_be_of_the_layout_without_digests(spoilt):
    change(spoilt.store.path, "PRAGMA user_version = 1", f"UPDATE results SET fun = 0 WHERE {ONE}")
    assert {*spoilt.store.check().damaged} == CHANGED


def test_digests_of_two_stores_differ(filled, spoilt, tmp_path):
    """So that a row cannot be taken over from another run of the study, with its digest."""
    other = Folder(tmp_path / "other")
    other.path.mkdir()
    add_missing(other)
    change(
        spoilt.store.path,
        f"ATTACH '{other.store.path}' AS other",
        f"UPDATE results SET digest = (SELECT digest FROM other.results WHERE {ONE}) WHERE {ONE}",
    )
    assert {*spoilt.store.check().damaged} == CHANGED


@pytest.fixture
def several(monkeypatch):
    """Have even a small store read by three processes."""
    monkeypatch.setattr(digests, "shares", lambda connection: 3)
    monkeypatch.setattr("bench.storage.reading.shares", lambda connection: 3)
    monkeypatch.setattr("bench.storage.results.MANY", 0)


def test_several_processes_find_what_one_finds(several, filled, spoilt):
    found = filled.store.check()
    assert (found.trials, found.sound) == (120, True)
    change(
        spoilt.store.path,
        f"UPDATE results SET fun = 0 WHERE cell = {SCATTER} AND trial IN (6, 7, 8, 9)",
        f"UPDATE results SET trial = -1 WHERE cell = {EARLY} AND trial = 1",
    )
    damaged = {("sphere-2", "scatter", number) for number in (6, 7, 8, 9)}
    damaged |= {("sphere-2", "early", number) for number in (-1, 1)}
    assert {*spoilt.store.check().damaged} == {*Results(spoilt.path).stores[0].damaged} == damaged


def test_the_frame_does_not_depend_on_the_number_of_processes(several, filled, spoilt, monkeypatch):
    change(spoilt.store.path, f"UPDATE results SET fun = 0 WHERE {ONE}")
    read = [Results(folder.path).frame for folder in (filled, spoilt)]
    monkeypatch.undo()
    for frame, folder in zip(read, (filled, spoilt), strict=True):
        pd.testing.assert_frame_equal(frame, Results(folder.path).frame, check_exact=True)


class Killed(subprocess.Popen):
    """A process that is killed as soon as it has started."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.kill()


def test_a_process_that_is_killed_costs_only_time(several, filled, monkeypatch):
    expected = Results(filled.path).frame
    monkeypatch.setattr(subprocess, "Popen", Killed)
    found = filled.store.check()
    assert (found.trials, found.sound) == (120, True)
    pd.testing.assert_frame_equal(Results(filled.path).frame, expected, check_exact=True)


def test_ctrl_c_is_not_taken_for_damage(filled, monkeypatch):
    """SQLite hides what is raised in a function that it calls."""

    def interrupted(*row):
        raise KeyboardInterrupt

    monkeypatch.setattr(digests, "_sound", lambda keys, damaged: interrupted)
    with pytest.raises(KeyboardInterrupt):
        filled.store.check()
    with pytest.raises(KeyboardInterrupt):
        list(filled.store.rescued_rows(TRIALS))
