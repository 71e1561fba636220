"""Results on a file system that cannot be written, as an archive or somebody else's folder."""

import os

import pandas as pd
import pytest

from bench import load_results, run, write_report


@pytest.fixture
def read_only(monkeypatch):
    """Make folders look read-only to the code; the tests may run as a user who may write anywhere."""

    def freeze(folder):
        access = os.access
        monkeypatch.setattr(os, "access", lambda path, mode: str(path) != str(folder) and access(path, mode))

    return freeze


@pytest.mark.slow
def test_a_read_only_study_can_be_read_and_reported_elsewhere(small_study, tmp_path, read_only):
    run(small_study, tmp_path / "out", n_jobs=1)
    before = load_results(tmp_path / "out")
    for beside in (tmp_path / "out").glob("trials.sqlite-*"):
        beside.unlink()
    read_only(tmp_path / "out")
    files = sorted(path.name for path in (tmp_path / "out").iterdir())
    pd.testing.assert_frame_equal(load_results(tmp_path / "out"), before)
    page = write_report(tmp_path / "out", output=tmp_path / "report")
    assert page.exists()
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == files
