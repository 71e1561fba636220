import pytest


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Some of the faulty optimizers leave files."""
    monkeypatch.chdir(tmp_path)
