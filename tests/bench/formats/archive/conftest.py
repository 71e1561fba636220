import json
import shutil
import zipfile

import pytest

from bench.formats.archive import pack
from bench.storage.folder import Folder
from tests.bench.storage.filled import filled_folder


@pytest.fixture(scope="session")
def whole(tmp_path_factory):
    """A study's folder of 120 trials with a report of two files, which no test changes."""
    folder = filled_folder(tmp_path_factory.mktemp("packing") / "small", title="A small study")
    folder.write_environments()
    (folder.path / "tables").mkdir()
    (folder.path / "tables" / "cells.csv").write_text("problem,median\nsphere-2,0.5\n")
    (folder.path / "report.html").write_text("<!doctype html><title>A small study</title>")
    (folder.path / ".report.json").write_text(json.dumps(["report.html", "tables/cells.csv"]))
    (folder.path / "notes of mine.txt").write_text("private")
    return folder


@pytest.fixture
def copied(whole, tmp_path):
    """A copy of it that a test may change."""
    shutil.copytree(whole.path, tmp_path / "copy")
    return Folder(tmp_path / "copy")


@pytest.fixture(scope="session")
def packed(whole, tmp_path_factory):
    """An archive of it, which no test changes."""
    return pack(whole.path, tmp_path_factory.mktemp("archive") / "small.zip").path


@pytest.fixture(scope="session")
def content(packed):
    """The content of every file of the archive, by name."""
    with zipfile.ZipFile(packed) as archive:
        return {name: archive.read(name) for name in archive.namelist()}
