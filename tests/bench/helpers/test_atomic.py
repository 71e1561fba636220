from pathlib import Path

import pytest

from bench import BenchError
from bench.helpers.atomic import replacing


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), ValueError("no")])
def test_after_an_error_nothing_is_left_and_the_old_file_is_there(tmp_path, error):
    def fail(path):
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise error

    path = tmp_path / "a.csv"
    path.write_text("old")
    with pytest.raises(ValueError, match=r"a.csv cannot be written: No space left|^no$"):
        fail(path)
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]
    assert path.read_text() == "old"


def test_a_device_is_not_replaced():
    device = Path("/dev/full")
    with pytest.raises(BenchError, match="it is neither a file nor a folder"), replacing(device):
        pytest.fail("nothing may be written")
    assert device.is_char_device()


def test_a_folder_replaces_a_folder(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old.txt").write_text("old")
    with replacing(tmp_path / "out") as temporary:
        temporary.mkdir()
        (temporary / "new.txt").write_text("new")
    assert [each.name for each in (tmp_path / "out").iterdir()] == ["new.txt"]
    assert [each.name for each in tmp_path.iterdir()] == ["out"]
