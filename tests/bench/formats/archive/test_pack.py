import hashlib
import json
import shutil
import sqlite3

import pandas as pd
import pytest

from bench import BenchError, load_results
from bench.formats.archive import pack, unpack
from bench.storage.folder import Folder
from tests.bench.storage.changes import change
from tests.bench.storage.filled import TRIALS


def test_an_archive_holds_results_study_environments_hashes_and_report(content):
    assert sorted(content) == [
        ".report.json", "SHA256SUMS", "environment.json", "report.html", "study.toml",
        "tables/cells.csv", "trials.sqlite",
    ]  # fmt: skip


def test_the_checksums_are_those_of_the_files(content):
    lines = dict(reversed(line.split("  ")) for line in content["SHA256SUMS"].decode().splitlines())
    assert lines == {name: hashlib.sha256(each).hexdigest() for name, each in content.items() if name != "SHA256SUMS"}


def test_the_same_folder_gives_the_same_bytes(whole, tmp_path):
    shutil.copytree(whole.path, tmp_path / "copy")  # other times of the files
    archives = [pack(folder, tmp_path / f"{n}.zip").path for n, folder in enumerate((whole.path, tmp_path / "copy"))]
    assert archives[0].read_bytes() == archives[1].read_bytes()


def test_the_trials_are_those_of_the_folder_also_while_it_is_written(copied, tmp_path):
    """Rows that are committed in the write-ahead log alone are packed; those of an open transaction are not."""
    with copied.store.writer() as writer:
        writer.remove([4])
        connection = sqlite3.connect(copied.store.path)
        connection.execute("DELETE FROM results WHERE trial = 28")
        done = pack(copied.path, tmp_path / "a.zip")
        connection.rollback()
        connection.close()
    assert done.trials == 3 * TRIALS
    assert "30 of the study's 120 trials are missing" in done.notes
    unpack(done.path, tmp_path / "there")
    pd.testing.assert_frame_equal(load_results(tmp_path / "there"), load_results(copied.path), check_exact=True)


def test_no_path_of_the_machine_is_packed(copied, tmp_path):
    with copied.store.writer() as writer:
        writer.change(1, copied.environments()[0] | {"working_folder": "/home/me/secret"})
    unpack(pack(copied.path, tmp_path / "a.zip").path, tmp_path / "there")
    assert Folder(tmp_path / "there").environments()[0]["working_folder"] == ""
    assert not any(b"/home/me/secret" in file.read_bytes() for file in (tmp_path / "there").rglob("*.*"))
    assert copied.environments()[0]["working_folder"] == "/home/me/secret"


def test_nothing_of_the_folder_is_changed_and_nothing_is_left_beside_the_archive(copied, tmp_path):
    before = {file: file.read_bytes() for file in copied.path.rglob("*") if file.is_file()}
    pack(copied.path, tmp_path / "new" / "a.zip")
    assert {file: file.read_bytes() for file in copied.path.rglob("*") if file.is_file()} == before
    assert [file.name for file in (tmp_path / "new").iterdir()] == ["a.zip"]


def test_notes_name_what_a_reader_would_miss(copied, tmp_path):
    (copied.path / "report.html").unlink()
    notes = pack(copied.path, tmp_path / "a.zip").notes
    assert [note.partition(",")[0] for note in notes] == ["the archive has no report"]


def missing(folder):
    (folder.path / "tables" / "cells.csv").unlink()


def linked(folder):
    missing(folder)
    (folder.path / "tables" / "cells.csv").symlink_to(folder.path / "report.html")


def listed(*names):
    return lambda folder: (folder.path / ".report.json").write_text(json.dumps(names))


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (missing, r"cells.csv, a file of the report, is missing; write the report again"),
        (linked, r"cells.csv is a link"),
        *(
            (listed(name), "which is no file of a report")
            for name in ("../secret.csv", "/etc/passwd", "tables/../../secret.csv", "study.toml", ".lock")
        ),
        (lambda folder: folder.store.path.unlink(), r"there is no trials.sqlite"),
        (
            lambda folder: change(folder.store.path, "UPDATE results SET fun = 0 WHERE cell = 1 AND trial = 0"),
            r"1 of 120 trials are damaged \(scatter on sphere-2, trial 0\)",
        ),
    ],
)
def test_what_is_no_sound_folder_is_not_packed(spoil, sentence, copied, tmp_path):
    spoil(copied)
    with pytest.raises(BenchError, match=sentence):
        pack(copied.path, tmp_path / "new" / "a.zip")
    assert not [*(tmp_path / "new").glob("*")]


def test_an_earlier_archive_is_replaced_and_another_file_is_not(whole, tmp_path):
    pack(whole.path, tmp_path / "a.zip")
    pack(whole.path, tmp_path / "a.zip")
    (tmp_path / "thesis.docx").write_text("mine")
    for other in ("thesis.docx", "."):
        with pytest.raises(BenchError, match=r"is another file than an archive|is a folder"):
            pack(whole.path, tmp_path / other)
    assert (tmp_path / "thesis.docx").read_text() == "mine"
