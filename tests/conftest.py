import gc
import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings

# A busy machine must not fail a property, nor two runs of one commit differ.
settings.register_profile("suite", deadline=None, derandomize=True)
settings.load_profile("suite")

# Looking for garbage among the million objects of numba, pandas and matplotlib takes a sixth of the suite's time.
gc.set_threshold(20_000, 50, 100)

# The workers of xdist take the cores: a report of their tests is drawn, and a study run, by one process more at most.
os.environ.setdefault("LOKY_MAX_CPU_COUNT", "1")

# Hundreds of processes import pandas, numba and matplotlib: without bytecode files each would take seconds more.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False

SLOWEST = (
    "test_distributions.py", "test_examples.py", "test_reference_results.py", "test_hostile.py", "test_crash.py",
    "test_cma_es_fast.py", "test_app.py", "test_dask.py", "test_problem.py", "test_checker.py",
)  # fmt: skip


def pytest_collection_modifyitems(items):
    """Begin with the files that take longest, so that no worker is left alone with one of them at the end."""
    items.sort(key=lambda item: SLOWEST.index(item.path.name) if item.path.name in SLOWEST else len(SLOWEST))


@pytest.fixture(scope="session")
def published() -> Path:
    """The folder with the thesis authors' published recordings; a test that needs it is skipped where there is none."""
    default = Path(__file__).resolve().parents[1].parent / "shared" / "data"
    folder = Path(os.environ.get("BENCH_PUBLISHED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no published recordings at {folder}: set BENCH_PUBLISHED_DATA to their folder")
    return folder
