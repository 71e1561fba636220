import os
from pathlib import Path

import pytest
from hypothesis import settings

# A busy machine must not fail a property, nor two runs of one commit differ.
settings.register_profile("suite", deadline=None, derandomize=True)
settings.load_profile("suite")


@pytest.fixture(scope="session")
def published() -> Path:
    """The folder with the thesis authors' published recordings; a test that needs it is skipped where there is none."""
    default = Path(__file__).resolve().parents[1].parent / "shared" / "data"
    folder = Path(os.environ.get("BENCH_PUBLISHED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no published recordings at {folder}: set BENCH_PUBLISHED_DATA to their folder")
    return folder
