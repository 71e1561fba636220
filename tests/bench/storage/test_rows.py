"""A row comes back to the last bit, and one that was changed is noticed, whoever changed what of it."""

from marshal import dumps

import numpy as np
import pytest

from bench import BenchError, Results
from bench.storage.rows import FORMAT, typed
from tests.bench.storage.changes import EARLY, SCATTER, change
from tests.bench.storage.filled import OPTIMIZERS, PROBLEMS, TRIALS, assert_refused

ONE = f"cell = {SCATTER} AND trial = 7"
CHANGED = {("sphere-2", "scatter", 7)}


def in_words(keys):
    return {
        f"{optimizer} on {problem}, {'an unknown trial' if trial < 0 else f'trial {trial}'}"
        for problem, optimizer, trial in keys
    }


TEXTS = ("status", "stop", "error")
BLOBS = ("x", "metrics", "trace")


def test_the_bytes_that_are_hashed_are_the_same_in_every_version_of_python():
    """Stores move between versions; marshal promises nothing, so this test holds its format 2."""
    row = (7, None, 2**62, b"ok", 0.1, -1, 2**31)
    expected = "2807000000 6907000000 4e 6c050000000000000000000000 0400 73020000006f6b 679a9999999999b93f 69ffffffff"
    assert dumps(row, FORMAT) == bytes.fromhex(f"{expected} 6c03000000000000000200")


def test_a_column_that_the_store_does_not_have_is_refused():
    with pytest.raises(ValueError, match="no column 'figures'"):
        typed({"status": "ok", "figures": {}})


def test_numbers_of_other_types_are_written_as_they_are_read(spoilt):
    """A digest of what is written must fit what SQLite returns."""
    row = {
        "problem": "sphere-2", "optimizer": "scatter", "trial": 99, "status": "ok", "fun": np.float64(0.1), "wall_s": 3,
        "nfev": np.int64(7), "outside_box": False, "cpu_s": np.nan, "seed": 2**63 - 1,
    }  # fmt: skip
    with spoilt.store.writer() as writer, writer.transaction():
        writer.put(row)
    assert spoilt.store.check().sound
    found = spoilt.store.find("sphere-2", "scatter", 99)
    assert [found[name] for name in ("fun", "wall_s", "nfev", "outside_box", "cpu_s")] == [0.1, 3.0, 7, 0, None]


def test_a_store_as_it_was_written_is_sound_and_stays_so(filled):
    before = filled.store.path.read_bytes()
    found = filled.require_sound()
    assert filled.store.path.read_bytes() == before
    assert (found.sound, found.trials) == (True, 120)
    assert found.sentence == "all 120 trials are as they were written"


@pytest.mark.sampled(8)
@pytest.mark.parametrize(
    "statement",
    [
        *(f"UPDATE results SET {name} = {name} + 1" for name in ("seed", "nfev", "outside_box", "environment")),
        *(f"UPDATE results SET {name} = {name} * (1 + 1e-15)" for name in ("fun", "wall_s", "cpu_s", "objective_s")),
        *(f"UPDATE results SET {name} = coalesce({name}, '') || ' '" for name in TEXTS),
        *(f"UPDATE results SET {name} = CAST(x'ff' AS TEXT)" for name in ("x", "error", "fun", "nfev", "digest")),
        *(f"UPDATE results SET {name} = NULL" for name in ("fun", "x", "metrics", "trace", "names", "digest")),
        *(f"UPDATE results SET {name} = x'' || {name} || x'00'" for name in BLOBS),
        *(f"UPDATE results SET {name} = substr({name}, 2) || x'11'" for name in BLOBS),
        "UPDATE results SET x = substr(x, 1, 15) || x'00'",  # -0.0 becomes 0.0
        "UPDATE results SET status = 'failed'",
        "UPDATE results SET digest = x'0011223344556677'",
        "UPDATE results SET digest = (SELECT digest FROM results WHERE trial = 8)",
        "UPDATE results SET names = 77",
        "UPDATE results SET names = x'01'",
    ],
)
def test_a_changed_row_is_named_and_nothing_is_read_beside_it(statement, spoilt):
    change(spoilt.store.path, f"{statement} WHERE {ONE}")
    found = spoilt.store.check()
    assert {*found.damaged} == in_words(CHANGED)
    assert found.sentence == "1 of 120 trials are damaged (scatter on sphere-2, trial 7)"
    for part in ("frame", "traces"):
        with pytest.raises(BenchError, match=r"\(scatter on sphere-2, trial 7\); restore trials.sqlite"):
            getattr(Results(spoilt.path), part)
    assert_refused(spoilt)


OTHERS = {
    "a row replaced by plain SQL": (
        [f"CREATE TEMP TABLE row AS SELECT * FROM results WHERE {ONE}", f"DELETE FROM results WHERE {ONE}",
         "UPDATE row SET fun = 0", "INSERT INTO results SELECT * FROM row"],
        CHANGED,
    ),
    "two trials that changed places": (
        [f"UPDATE results SET trial = {new} WHERE cell = {SCATTER} AND trial = {old}"
         for old, new in ((7, -1), (8, 7), (-1, 8))],
        {("sphere-2", "scatter", 7), ("sphere-2", "scatter", 8)},
    ),
    "a trial moved to another number": (
        [f"DELETE FROM results WHERE cell = {SCATTER} AND trial = 8", f"UPDATE results SET trial = 8 WHERE {ONE}"],
        {("sphere-2", "scatter", 8)},
    ),
    "a trial moved to another optimizer": (
        [f"DELETE FROM results WHERE cell = {EARLY} AND trial = 7", f"UPDATE results SET cell = {EARLY} WHERE {ONE}"],
        {("sphere-2", "early", 7)},
    ),
    "optimizers that changed their records": (
        ["UPDATE optimizers SET id = -id", "UPDATE optimizers SET id = 3 + id"],
        {(problem, optimizer, trial) for problem in PROBLEMS for optimizer in OPTIMIZERS for trial in range(TRIALS)},
    ),
    "an option that was edited": (
        ["UPDATE optimizers SET record = replace(record, '{}', '{{}}') WHERE record LIKE '%scatter%'"],
        {(problem, "scatter", trial) for problem in PROBLEMS for trial in range(TRIALS)},
    ),
    "evaluations that were edited": (
        [f"UPDATE cells SET evaluations = 7 WHERE id = {SCATTER}"],
        {("sphere-2", "scatter", trial) for trial in range(TRIALS)},
    ),
    "a cell removed": (
        [f"DELETE FROM cells WHERE id = {SCATTER}"],
        {("sphere-2", "scatter", trial) for trial in range(TRIALS)},
    ),
    "a trial beyond all numbers": (
        [f"UPDATE results SET trial = {2**62} WHERE {ONE}"],
        {("sphere-2", "scatter", 2**62)},
    ),
    "a trial that is no number": ([f"UPDATE results SET trial = 'x' WHERE {ONE}"], {("sphere-2", "scatter", -1)}),
    "variables that changed their names": (
        ["UPDATE names SET variables = replace(variables, 'x1', 'x3')"],
        {(problem, optimizer, trial) for problem in ("sphere-2", "sphere-3") for optimizer in OPTIMIZERS
         for trial in range(TRIALS) if trial % 10 != 3},
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE selected SET optimizer = 'gwo' WHERE optimizer = 'scatter'",
        f"DELETE FROM selected WHERE cell = {EARLY}",
        "UPDATE selected SET cell = -cell", "UPDATE study SET identity = 'other'", "DELETE FROM study",
    ],
)  # fmt: skip
def test_a_selection_that_another_program_changed_is_not_read_and_is_made_again(statement, spoilt):
    change(spoilt.store.path, statement)
    with pytest.raises(BenchError, match="the selection of cells is not as it was written; restore it from a copy"):
        Results(spoilt.path)
    assert_refused(spoilt)


@pytest.mark.parametrize("what", OTHERS)
def test_what_another_program_did_is_named(what, spoilt):
    statements, damaged = OTHERS[what]
    change(spoilt.store.path, *statements)
    assert {*spoilt.store.check().damaged} == in_words(damaged)
    assert_refused(spoilt)


def test_a_trial_that_another_program_removed_is_missing(spoilt):
    change(spoilt.store.path, f"DELETE FROM results WHERE {ONE}")
    found = spoilt.store.check()
    assert (found.sound, found.trials, found.missing) == (False, 119, 1)
    assert found.sentence == "1 of 120 committed trials are missing"
    assert spoilt.store.check_count() == found
    assert_refused(spoilt)


def test_a_damaged_count_of_commits_is_noticed(spoilt):
    before = spoilt.store.path.read_bytes()
    for statement in ("DELETE FROM committed", "UPDATE committed SET trials = 'x'", "DROP TABLE committed"):
        spoilt.store.path.write_bytes(before)
        change(spoilt.store.path, statement)
        assert "its count of commits cannot be read" in spoilt.store.check().sentence
        assert_refused(spoilt)
