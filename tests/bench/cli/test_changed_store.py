"""What commands print of a store that another program changed, and what they do about it."""

import shutil

import pytest

from bench import load_results, run
from tests.bench.storage.changes import SCATTER, change

SENTENCE = "1 of 18 trials are damaged (scatter on sphere-2, trial 1)"


@pytest.fixture(scope="module")
def made(tmp_path_factory, small_study):
    place = tmp_path_factory.mktemp("made")
    (place / "small.toml").write_text(small_study.to_toml())
    run(small_study, place / "out", n_jobs=1)
    return place


@pytest.fixture
def changed(made, tmp_path):
    """The study's file and folder, with a trial that was changed by plain SQL."""
    shutil.copytree(made, tmp_path / "copy")
    change(
        tmp_path / "copy" / "out" / "trials.sqlite", f"UPDATE results SET fun = 0 WHERE trial = 1 AND cell = {SCATTER}"
    )
    return tmp_path / "copy" / "small.toml", tmp_path / "copy" / "out"


def test_status_prints_damage_where_it_compares_the_trials(bench_here, changed):
    _, out = changed
    checked = bench_here("status", out, "--check")
    assert checked.returncode == 1
    assert f"store: {SENTENCE}" in checked.stdout.splitlines()
    assert bench_here("status", out).returncode == 0


@pytest.mark.parametrize(
    "words", [["report"], ["export", "--format", "csv", "--output", "csv"], ["verify"], ["merge", "-o", "all"]]
)
def test_what_reads_a_changed_trial_refuses_the_folder_in_one_sentence(words, bench_here, changed):
    command, *options = words
    _, out = changed
    done = bench_here(command, out, *options, cwd=out.parent)
    assert done.returncode == 2
    assert done.stderr.startswith(f"bench: {out}: {SENTENCE}; restore trials.sqlite from a copy, or run the study")
    assert done.stderr.count("\n") == 1
    assert sorted(each.name for each in out.parent.iterdir()) == ["out", "small.toml"]


def test_the_next_run_refuses_it_and_another_folder_takes_the_others(bench_here, changed, made, tmp_path):
    study, out = changed
    refused = bench_here("run", study, "--output", out, "--jobs", 1)
    assert refused.returncode == 2
    assert f"{SENTENCE}; restore trials.sqlite from a copy, or run the study into another folder" in refused.stderr
    other = tmp_path / "other"
    done = bench_here("run", study, "--output", other, "--jobs", 1, "--reuse", out, "--no-report")
    assert "17 of them already done" in done.stdout
    again, before = load_results(other), load_results(made / "out")
    times = ["wall_s", "cpu_s", "objective_s", "memory_mb"]
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
    for command in (["run", study, "--output", out, "--jobs", 1], ["verify", out, "--jobs", 1]):
        done = bench_here(*command)
        assert done.returncode == 2
        assert "of 8 trials are damaged (scatter on sphere-2, trial" in done.stderr
