import shutil

import pytest

from bench.storage.folder import Folder
from tests.bench.storage.filled import filled_folder


@pytest.fixture(scope="session")
def filled(tmp_path_factory):
    """A study's folder of 120 trials, which no test changes."""
    folder = filled_folder(tmp_path_factory.mktemp("whole") / "small")
    folder.write_environments()
    return folder


@pytest.fixture
def spoilt(filled, tmp_path):
    """A copy of it that a test may change."""
    shutil.copytree(filled.path, tmp_path / "copy")
    return Folder(tmp_path / "copy")
