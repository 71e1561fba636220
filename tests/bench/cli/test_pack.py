"""The commands pack and unpack."""

import zipfile

from bench import Study
from bench.storage.folder import Folder
from tests.bench.storage.filled import OPTIMIZERS, PROBLEMS, TRIALS, add_missing


def test_pack_and_unpack_print_what_they_did(bench_here, tmp_path):
    folder = Folder(tmp_path / "copy")
    folder.path.mkdir()
    study = {"name": "small", "trials": TRIALS, "problems": [{"names": [*PROBLEMS]}]}
    folder.claim(Study.from_dict(study | {"optimizers": [{"name": name} for name in OPTIMIZERS]}))
    add_missing(folder)
    done = bench_here("pack", folder.path)
    assert done.returncode == 0
    assert "note: the archive has no report" in done.stdout
    assert f"{4 * TRIALS} trials in 4 files: " in done.stdout
    assert zipfile.is_zipfile(tmp_path / "copy.zip")
    done = bench_here("unpack", tmp_path / "copy.zip", "-o", tmp_path / "there")
    assert f"all {4 * TRIALS} trials are as they were written" in done.stdout
