"""Commits that are lost are noticed: in a damaged write-ahead log, with an emptied, removed or older store."""

import json
import random
import shutil

import pandas as pd
import pytest

from bench import BenchError, Results, load_results
from bench.storage.committed import FILE, Committed, read
from bench.storage.folder import Folder
from bench.trial.columns import packed
from tests.bench.storage.filled import RECORD, damage_of, rows, traces

MORE = 67  # trials in the write-ahead log alone


@pytest.fixture(scope="module")
def killed(filled, tmp_path_factory):
    """The folder as a run leaves it that is killed: some trials are in the store, the others in its log."""
    place = tmp_path_factory.mktemp("killed")
    folder, every = Folder(place / "run"), list(rows())
    folder.path.mkdir()
    folder.claim(filled.study())
    for some, last in ((every[:-MORE], False), (every[-MORE:], True)):
        with folder.store.writer() as writer:
            number = writer.record("environments", RECORD)
            for trial, row in some:
                writer.add(trial, packed(row), number)
            if last:
                shutil.copytree(folder.path, place / "killed", ignore=shutil.ignore_patterns("*-shm"))
    return Folder(place / "killed")


@pytest.fixture
def left(killed, tmp_path):
    """A copy of it that a test may change."""
    return copied(killed, tmp_path / "left")


def copied(folder, place):
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(folder.path, place)
    return Folder(place)


def flip(log, rng):
    content = bytearray(log.read_bytes())
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    log.write_bytes(content)


def cut(log, rng):
    log.write_bytes(log.read_bytes()[: rng.randrange(log.stat().st_size)])


def remove(log, rng):
    log.unlink()


def test_a_killed_run_leaves_all_it_committed(killed, left, filled):
    assert left.store.check(structure=True).sentence == "all 120 trials are as they were written"
    pd.testing.assert_frame_equal(Results(left.path).frame, Results(filled.path).frame, check_exact=True)
    assert (killed.path / "trials.sqlite-wal").stat().st_size > 50_000


@pytest.mark.parametrize("damage", [flip, cut, remove])
@pytest.mark.parametrize("seeds", [range(8), pytest.param(range(8, 80), marks=pytest.mark.slow)], ids=["few", "many"])
def test_damage_of_the_log_is_noticed(damage, seeds, killed, filled, tmp_path):
    original = Results(filled.path)
    frame, known = original.frame, traces(original)
    noticed = 0
    for seed in seeds if damage is not remove else seeds[:1]:
        spoilt = copied(killed, tmp_path / "copy")
        damage(spoilt.path / "trials.sqlite-wal", random.Random(seed))
        said = damage_of(spoilt, original, frame, known)
        assert not said or "copy" in said, seed
        noticed += bool(said)
    assert noticed


def test_the_number_of_lost_trials_is_reported(left):
    (left.path / "trials.sqlite-wal").unlink()
    sentence = f"{MORE} of 120 committed trials are missing"
    assert left.store.check_count().sentence == left.store.check().sentence == sentence
    with pytest.raises(BenchError, match=f"cannot be written: {MORE} of 120"), left.store.writer():
        pass
    for read_by in (left.require_sound, lambda: load_results(left.path)):
        with pytest.raises(BenchError, match=f"{sentence}; restore trials.sqlite from a copy"):
            read_by()


@pytest.mark.parametrize("what", ["emptied", "removed"])
def test_a_store_that_is_gone_is_not_taken_for_a_new_one(what, left):
    left.store.path.write_bytes(b"") if what == "emptied" else left.store.path.unlink()
    assert left.store.check_count().sentence.startswith("120 of 120 committed trials are missing")
    with pytest.raises(BenchError, match="cannot be written: 120 of 120"), left.store.writer():
        pass
    with pytest.raises(BenchError, match="120 of 120 committed trials are missing; restore"):
        left.require_sound()


def test_an_older_copy_of_the_store_is_noticed_though_it_has_as_many_rows(spoilt):
    """A failed trial was replaced by a finished one since."""
    older = spoilt.store.path.read_bytes()
    trial, _ = next(each for each in rows() if each[1]["status"] == "failed")
    _, row = next(each for each in rows() if each[1]["status"] == "ok")
    with spoilt.store.writer() as writer:
        writer.add(trial, packed(row))
    spoilt.store.path.write_bytes(older)
    assert spoilt.store.check().sentence == "the last 1 commits are lost"


@pytest.mark.parametrize("note", [None, b"", b"{", b"[]", b'{"commits": 3}', b'{"commits": "x", "trials": 7}'])
def test_a_note_that_is_missing_or_damaged_is_written_again(note, spoilt):
    place = spoilt.path / FILE
    noted = read(spoilt.path)
    place.unlink() if note is None else place.write_bytes(note)
    assert spoilt.store.check().sound
    with spoilt.store.writer():
        pass
    assert read(spoilt.path) == noted
    assert noted.trials == 120


def test_a_note_that_lags_behind_after_a_kill_is_no_damage(spoilt):
    noted = read(spoilt.path)
    (spoilt.path / FILE).write_text(json.dumps(Committed(noted.commits - 1, noted.trials - 1)._asdict()))
    spoilt.require_sound()


def test_removed_trials_are_not_missing(spoilt):
    with spoilt.store.writer() as writer:
        assert writer.remove([2]) == 30
    assert spoilt.store.check().sentence == "all 90 trials are as they were written"


@pytest.mark.parametrize("how", ["removed", "replaced", "moved with its folder"])
def test_a_store_that_is_taken_away_while_it_is_written_ends_the_writing(how, spoilt, tmp_path):
    trial, row = next(rows())
    with spoilt.store.writer() as writer:
        writer.remove([1])
        if how == "moved with its folder":
            spoilt.path.rename(tmp_path / "elsewhere")
        else:
            spoilt.store.path.unlink()
        if how == "replaced":
            spoilt.store.path.touch()
        with pytest.raises(BenchError, match="was removed or replaced while it was written"):
            writer.add(trial, packed(row))
