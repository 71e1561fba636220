import shutil

import pytest

from bench import Study
from bench.storage.folder import Folder
from tests.bench.storage.filled import OPTIMIZERS, PROBLEMS, TRIALS, add_missing


@pytest.fixture(scope="session")
def filled(tmp_path_factory):
    """A study's folder of 120 trials, which no test changes."""
    folder = Folder(tmp_path_factory.mktemp("whole") / "small")
    folder.path.mkdir()
    study = {
        "name": "small", "trials": TRIALS, "budget": 60, "problems": [{"names": [*PROBLEMS]}],
        "optimizers": [{"name": name} for name in OPTIMIZERS],
    }  # fmt: skip
    folder.claim(Study.from_dict(study))
    add_missing(folder)
    folder.write_environments()
    return folder


@pytest.fixture
def spoilt(filled, tmp_path):
    """A copy of it that a test may change."""
    shutil.copytree(filled.path, tmp_path / "copy")
    return Folder(tmp_path / "copy")
