"""The commands that read results: report, export and check."""

import csv
import json
import shutil

import pytest

from bench import Study, run, write_report
from bench.storage.folder import Folder

ENTRIES = [{"name": "scatter", "agents": 7}, {"name": "early"}]


@pytest.fixture(scope="module")
def folders(tmp_path_factory, testing_plugins):
    """Return the folders of an old and a new version."""
    place = tmp_path_factory.mktemp("runs")
    base = {"name": "tiny", "trials": 4, "budget": 40, "problems": [{"names": ["sphere-2", "sphere-3"]}]}
    changes = {
        "old": {"optimizers": ENTRIES},
        "new": {"optimizers": [{"name": "scatter", "agents": 9}, {"name": "early"}], "seed": 1},
    }
    for name, change in changes.items():
        run(Study.from_dict(base | change), place / name, n_jobs=1)
    return place


@pytest.mark.slow
def test_a_report_may_use_other_targets_than_the_study(bench_here, folders, tmp_path):
    done = bench_here("report", folders / "old", "--output", tmp_path / "out", "--targets", "1e-1, 10")
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out" / "tables" / "running-times.csv").open() as file:
        assert {row["precision"] for row in csv.DictReader(file)} == {"10.0", "0.1"}
    assert "2 precisions from 10 to 0.1" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_two_folders_make_one_report(bench_here, folders, tmp_path):
    done = bench_here("report", folders / "old", folders / "new", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    page = tmp_path / "results" / "comparisons" / "old-new" / "report.html"
    assert f"report: {page.relative_to(tmp_path)}" in done.stdout
    assert "chance" in done.stdout
    with (page.parent / "tables" / "comparison.csv").open() as file:
        cells = {(row["problem"], row["optimizer"]) for row in csv.DictReader(file)}
    labels = ["scatter (old)", "early (old)", "scatter (new)", "early (new)"]
    assert cells == {(problem, label) for problem in ("sphere-2", "sphere-3") for label in labels}
    assert "scatter (old)" in page.read_text(encoding="utf-8")
    assert not (folders / "old" / "report.html").exists()


def test_status_prints_the_answer_of_a_report_of_these_trials_only(bench_here, folders, tmp_path):
    shutil.copytree(folders / "old", tmp_path / "s")
    state = Folder(tmp_path / "s").store.state()
    answer = {"sentence": "scatter is best.", "columns": ["optimizer"], "rows": [["scatter"]], "state": state}
    (tmp_path / "s" / "answer.json").write_text(json.dumps(answer))
    assert "scatter is best." in bench_here("status", tmp_path / "s").stdout
    (tmp_path / "s" / "answer.json").write_text(json.dumps(answer | {"state": "other"}))
    done = bench_here("status", tmp_path / "s")
    assert "scatter is best." not in done.stdout
    assert "the report is older than the trials; write it again: bench report" in done.stdout


@pytest.mark.slow
def test_a_report_that_is_written_again_leaves_no_stale_file_and_touches_no_foreign_one(folders, tmp_path):
    out = tmp_path / "out"
    write_report(folders / "old", output=out)
    first = {path.name for path in (out / "tables").iterdir()}
    for name in ("stale.csv", "mine.csv"):
        (out / "tables" / name).write_text("a\n1\n")
    (tmp_path / "keep.txt").write_text("")
    (out / ".report.json").write_text(json.dumps(["tables/stale.csv", "tables/../../keep.txt", "../keep.txt", 3]))
    write_report(folders / "old", output=out)
    assert {path.name for path in (out / "tables").iterdir()} == first | {"mine.csv"}
    assert (tmp_path / "keep.txt").exists()
