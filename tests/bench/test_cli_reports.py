"""The commands that read results: report, export and check."""

import csv
import json
import subprocess
import sys

import pytest

from bench import BenchError, Study, run, write_report

ENTRIES = [{"name": "scatter", "agents": 7}, {"name": "early"}]


def bench(*arguments, cwd=None):
    done = subprocess.run(
        [sys.executable, "-m", "bench", *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=300
    )
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


@pytest.fixture(scope="module")
def folders(tmp_path_factory, testing_plugins):
    """Return the folders of three runs: an old and a new version, and one with another budget."""
    place = tmp_path_factory.mktemp("runs")
    base = {"name": "tiny", "trials": 4, "budget": 40, "problems": [{"names": ["sphere-2", "sphere-3"]}]}
    changes = {
        "old": {"optimizers": ENTRIES},
        "new": {"optimizers": [{"name": "scatter", "agents": 9}, {"name": "early"}], "seed": 1},
        "short": {"optimizers": ENTRIES, "budget": 20},
    }
    for name, change in changes.items():
        run(Study.from_dict(base | change), place / name, n_jobs=1)
    return place


def test_two_folders_make_one_report(folders, tmp_path):
    done = bench("report", folders / "old", folders / "new", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    page = tmp_path / "results" / "comparisons" / "old-new" / "report.html"
    assert f"report: {page.relative_to(tmp_path)}" in done.stdout
    with (page.parent / "tables" / "comparison.csv").open() as file:
        cells = {(row["problem"], row["optimizer"]) for row in csv.DictReader(file)}
    labels = ["scatter (old)", "early (old)", "scatter (new)", "early (new)"]
    assert cells == {(problem, label) for problem in ("sphere-2", "sphere-3") for label in labels}
    assert "scatter (old)" in page.read_text(encoding="utf-8")
    assert not (folders / "old" / "report.html").exists()


def test_what_cannot_be_compared_ends_in_one_sentence(folders, tmp_path):
    done = bench("report", folders / "old", folders / "short", "--output", tmp_path / "out")
    assert done.returncode == 2
    assert "only runs of one budget can be compared" in done.stderr
    assert not (tmp_path / "out").exists()
    with pytest.raises(BenchError, match="whose own report would be lost"):
        write_report(folders / "old", folders / "new", output=folders / "short")


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


@pytest.mark.parametrize("kind", ["csv", "ioh"])
def test_export_says_where_it_wrote(folders, tmp_path, kind):
    done = bench("export", folders / "old", "--format", kind, "--output", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert f"export: {tmp_path / 'out'}" in done.stdout
    assert (tmp_path / "out" / "README.txt").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["export", "old", "--format", "xls"], "xls"),
        (["export", "nowhere", "--format", "csv"], "holds no study.toml"),
        (["report", "nowhere"], "holds no study.toml"),
        (["report", "old", "old"], "given twice"),
        (["check", "nothing"], "unknown optimizer 'nothing'"),
        (["check", "scatter", "--set", "agents=none"], "agents"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(folders, arguments, sentence):
    done = bench(*arguments, cwd=folders)
    assert done.returncode == 2
    assert sentence in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_checking_a_folder_warns_in_its_report(folders):
    done = bench("check", folders / "old")
    assert done.returncode == 0, done.stderr
    assert "passed: early, centre bias" in done.stdout
    noted = json.loads((folders / "old" / "checks.json").read_text())
    noted["scatter"][0] |= {"passed": False, "figure": 5e6}
    (folders / "old" / "checks.json").write_text(json.dumps(noted))
    assert bench("report", folders / "old").returncode == 0
    page = (folders / "old" / "report.html").read_text(encoding="utf-8")
    assert "away from the centre of the box: scatter 5e+06 times. Results on problems" in page
