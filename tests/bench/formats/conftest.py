import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def archived():
    """An archived data set of COCO: DIRECT on bbob, 2009, with five instances of each function."""
    shared = Path(__file__).resolve().parents[3].parent / "shared" / "data"
    file = Path(os.environ.get("BENCH_COCO_ARCHIVE", shared)) / "coco-archive-bbob-2009-DIRECT.tgz"
    if not file.is_file():
        pytest.skip(f"no archived data at {file}: set BENCH_COCO_ARCHIVE to its folder")
    return file


@pytest.fixture(scope="session")
def imported(archived, tmp_path_factory):
    """The folder of the imported data set."""
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    from bench.formats.importing import import_results

    folder = tmp_path_factory.mktemp("imported") / "direct"
    import_results(archived, folder)
    return folder
