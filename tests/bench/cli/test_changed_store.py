"""What commands print of a store that another program changed, and what they do about it."""

import shutil

import pytest

from bench import load_results, run
from bench.storage.folder import Folder
from tests.bench.storage.changes import SCATTER, change

SENTENCE = "1 of 18 trials are damaged (scatter on sphere-2, trial 1)"


@pytest.fixture(scope="module")
def made(tmp_path_factory, small):
    place = tmp_path_factory.mktemp("made")
    (place / "small.toml").write_text(small.to_toml())
    run(small, place / "out", n_jobs=1)
    return place


@pytest.fixture(scope="module")
def small():
    from bench import Study

    return Study.from_dict(
        {"name": "small", "trials": 3, "budget": 60, "seed": 5, "problems": [{"names": ["sphere-2", "sphere-3"]}],
         "optimizers": [{"name": "hill-climber"}, {"name": "scatter", "agents": 7}, {"name": "early"}]}
    )  # fmt: skip


@pytest.fixture
def changed(made, tmp_path):
    """The study's file and folder, with a trial that was changed by plain SQL."""
    shutil.copytree(made, tmp_path / "copy")
    change(
        tmp_path / "copy" / "out" / "trials.sqlite", f"UPDATE results SET fun = 0 WHERE trial = 1 AND cell = {SCATTER}"
    )
    return tmp_path / "copy" / "small.toml", tmp_path / "copy" / "out"


def test_status_prints_when_the_store_was_last_checked(bench_here, changed, made):
    assert "store checked 20" not in bench_here("status", made / "out").stdout
    assert "store not checked yet" in bench_here("status", made / "out").stdout
    _, out = changed
    assert "store not checked yet" in bench_here("status", out).stdout
    checked = bench_here("status", out, "--check")
    assert checked.returncode == 1
    assert SENTENCE in checked.stdout
    assert bench_here("status", out).returncode == 0
    noted = Folder(out).noted("store.json")
    assert f"store checked {noted['checked']}: {SENTENCE}" in bench_here("status", out).stdout.splitlines()


@pytest.mark.slow
def test_a_report_names_a_changed_trial_and_leaves_it_out(bench_here, changed):
    _, out = changed
    done = bench_here("report", out)
    assert done.returncode == 0
    assert f"{out}: {SENTENCE}" in done.stdout.splitlines()
    page = (out / "report.html").read_text()
    assert "1 of 18 trials are damaged" in page
    assert "1 of 18 planned trials are missing" in page
    assert SENTENCE in bench_here("status", out).stdout


def test_an_export_names_a_changed_trial_and_leaves_it_out(bench_here, changed, tmp_path):
    _, out = changed
    done = bench_here("export", out, "--format", "csv", "--output", tmp_path / "csv")
    assert f"note: out: {SENTENCE}" in done.stdout.splitlines()
    assert SENTENCE in (tmp_path / "csv" / "README.txt").read_text()
    assert len((tmp_path / "csv" / "trials.csv").read_text().splitlines()) == 18


def test_verify_names_a_changed_trial_and_ends_with_one(bench_here, changed):
    _, out = changed
    done = bench_here("verify", out, "--trials", 3, "--jobs", 1)
    assert done.returncode == 1
    assert SENTENCE in done.stdout.splitlines()
    assert "17 of 17 trials of 6 cells are the same bit by bit" in done.stdout


def test_merge_names_a_changed_trial(bench_here, changed, tmp_path):
    _, out = changed
    done = bench_here("merge", out, "-o", tmp_path / "all")
    assert f"{out}: {SENTENCE}" in done.stdout.splitlines()
    assert "17 trials in" in done.stdout


def test_the_next_run_refuses_it_and_another_folder_takes_the_others(bench_here, changed, made, tmp_path):
    study, out = changed
    refused = bench_here("run", study, "--output", out, "--jobs", 1)
    assert refused.returncode == 2
    assert f"{SENTENCE}; restore trials.sqlite from a copy, or run the study into another folder" in refused.stderr
    other = tmp_path / "other"
    done = bench_here("run", study, "--output", other, "--jobs", 1, "--reuse", out, "--no-report")
    assert "17 of them already done" in done.stdout
    again, before = load_results(other), load_results(made / "out")
    times = ["wall_s", "cpu_s", "objective_s"]
    assert again.drop(columns=times).equals(before.drop(columns=times))


HOSTILE = """
import sqlite3
import time

def edit(objective, rng):
    time.sleep(0.2)  # so that the trials before the last are committed
    objective(objective.initial(3))
    store = sqlite3.connect({path!r}, timeout=30)
    with store:
        store.execute(
            "UPDATE results SET fun = fun + 1 WHERE cell IN (SELECT cell FROM selected WHERE optimizer = 'scatter')"
        )
    store.close()
"""


@pytest.mark.slow
def test_an_optimizer_that_edits_the_rows_of_another_is_noticed(bench_here, tmp_path):
    out = tmp_path / "out"
    (tmp_path / "hostile.py").write_text(HOSTILE.format(path=str(out / "trials.sqlite")))
    study = tmp_path / "study.toml"
    study.write_text(
        'name = "edited"\ntrials = 4\nbudget = 30\nproblems = [{ name = "sphere-2" }]\n'
        f'optimizers = [{{ name = "scatter" }}, {{ name = "{tmp_path}/hostile.py:edit", label = "hostile" }}]\n'
    )
    done = bench_here("run", study, "--output", out, "--jobs", 1)
    assert "of 8 trials are damaged (scatter on sphere-2, trial" in done.stdout
    assert "trials are damaged" in (out / "report.html").read_text()
    assert "of 8 trials are damaged (scatter on sphere-2, trial" in bench_here("status", out, "--check").stdout
    verified = bench_here("verify", out, "--jobs", 1)
    assert verified.returncode == 1
    assert "of 8 trials are damaged (scatter on sphere-2, trial" in verified.stdout


def test_a_record_of_an_environment_that_was_changed_is_printed(bench_here, changed):
    study, out = changed
    change(out / "trials.sqlite", "UPDATE environments SET record = '{}'")
    assert "environment 1: damaged record" in bench_here("status", out).stdout
    refused = bench_here("run", study, "--output", out, "--jobs", 1, "--no-report")
    assert "the record of environment 1 is damaged; restore trials.sqlite from a copy" in refused.stderr
