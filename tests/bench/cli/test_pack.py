"""The commands pack and unpack."""

import zipfile

from tests.bench.storage.filled import TRIALS, filled_folder


def test_pack_and_unpack_print_what_they_did(bench_here, tmp_path):
    done = bench_here("pack", filled_folder(tmp_path / "copy").path)
    assert done.returncode == 0
    assert "note: the archive has no report" in done.stdout
    assert f"{4 * TRIALS} trials in 4 files: " in done.stdout
    assert zipfile.is_zipfile(tmp_path / "copy.zip")
    done = bench_here("unpack", tmp_path / "copy.zip", "-o", tmp_path / "there")
    assert f"all {4 * TRIALS} trials are as they were written" in done.stdout
