"""The note of a run's trials under way, which ends with the run."""

from bench.storage import under_way
from bench.trial.trial import Trial

HOLDER = {"pid": 1, "host": "here", "started": "2026-01-01T00:00:00+00:00"}
TRIAL = Trial("sphere", "gwo", 3, seed=99)


def test_a_run_that_ends_leaves_no_note(tmp_path):
    with under_way.noting(tmp_path, HOLDER) as noted:
        noted.begin(0, TRIAL)
        assert under_way.holder(tmp_path) == HOLDER
    assert not [*tmp_path.iterdir()]


def test_a_run_whose_note_cannot_be_removed_leaves_an_empty_one(tmp_path, monkeypatch):
    def refuse(path, *, missing_ok):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("pathlib.Path.unlink", refuse)  # root may remove files from any folder
    with under_way.noting(tmp_path, HOLDER) as noted:
        noted.begin(0, TRIAL)
    assert under_way.holder(tmp_path) == {}
    assert under_way.left(tmp_path)["trials"] == []
