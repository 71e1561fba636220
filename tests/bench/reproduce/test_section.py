"""A published table in a study's folder: imported beside trials, and shown in their report."""

import shutil

import pytest

import bench
from bench.reproduce.section import attach, section
from bench.topics import Findings
from tests.bench.reproduce.test_protocol import HEAD, ROWS, results  # noqa: F401 - a fixture


@pytest.fixture
def folder(results, tmp_path):  # noqa: F811
    return shutil.copytree(results.paths[0], tmp_path / "run")


def paper(tmp_path, name="paper.csv", text=f"# source = 'Doe 2020'\n# values = 'error'\n{HEAD}{ROWS}"):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / name


def shown(folder):
    return section(Findings(bench.Results(folder)))


def test_an_imported_table_stands_beside_the_trials(folder, tmp_path):
    attach(paper(tmp_path), folder)
    found = shown(folder)
    assert found.title == "In your units"
    (said,) = found.text
    assert said == (
        "Beside Doe 2020: 0 of 2 cells differ, tested at 5% over the table. "
        "2 are open: no test shows a difference, and their intervals are wider."
    )
    (table,) = found.items
    assert table.frame["ours"].tolist() == ["2 ± 1.3", "2 ± 1.3"]
    assert table.data["our_mean"].tolist() == [2.0, 2.0]
