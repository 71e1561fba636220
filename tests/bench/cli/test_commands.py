"""The commands around a run: status, rm, verify, merge, shards and the plan of a dry run."""

import json
import shutil
import subprocess
import sys
import time

import pytest

from bench import Study, load_results, run


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with finished and failed trials, and the study's file; no test changes them."""
    study = Study.from_dict(
        {"name": "mixed", "trials": 3, "budget": 30, "seed": 5, "problems": [{"names": ["sphere-2", "sphere-3"]}],
         "optimizers": [{"name": "faulty"}, {"name": "scatter", "agents": 7}]}
    )  # fmt: skip
    place = tmp_path_factory.mktemp("made")
    (place / "mixed.toml").write_text(study.to_toml())
    assert run(study, place / "out", n_jobs=1).failed == 3
    return place


@pytest.fixture
def copied(made, tmp_path):
    shutil.copytree(made, tmp_path / "copy")
    return tmp_path / "copy"


def test_status_prints_counts_reasons_and_provenance(bench_here, made):
    done = bench_here("status", made / "out")
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert lines[0].startswith("study mixed")
    assert [line.split()[:4] for line in lines[:5] if line.startswith(("faulty", "scatter"))] == [
        ["faulty", "3", "3", "6"], ["scatter", "6", "0", "6"]
    ]  # fmt: skip
    assert "failed: faulty on sphere-2, trial 0 and 2 more: RuntimeError: cannot do planes" in done.stdout
    record = json.loads((made / "out" / "environment.json").read_text())[0]
    for part in (
        record["started"],
        record["ended"],
        "12 trials on ",
        f"{record['host']} (local, jobs: 1)",
        record["command"],
    ):
        assert part in done.stdout
    assert "running" not in done.stdout


@pytest.mark.slow
def test_status_of_a_run_under_way(bench_here, tmp_path):
    (tmp_path / "slow.toml").write_text(
        'name = "slow"\ntrials = 10000\nbudget = 40\n[[problems]]\nname = "slow-2"\n'
        '[[optimizers]]\nname = "hill-climber"\n'
    )
    command = ["run", tmp_path / "slow.toml", "--output", tmp_path / "out", "--jobs", "1", "--no-report"]
    process = subprocess.Popen(
        [sys.executable, "-m", "bench", *map(str, command)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        said, deadline = "", time.monotonic() + 120  # ends a test that hangs
        while "a second" not in said and time.monotonic() < deadline:
            time.sleep(0.05)
            said = bench_here("status", tmp_path / "out").stdout if (tmp_path / "out" / "study.toml").exists() else ""
        assert f"running: process {process.pid} on " in said
        assert " made, " in said
        assert "left" in said
    finally:
        process.kill()
        process.wait()
    assert "running" not in bench_here("status", tmp_path / "out").stdout
    assert bench_here("status", tmp_path / "out", "--watch").returncode == 0  # nothing to watch: it ends at once


def test_rm_makes_a_cell_new(bench_here, copied):
    out = copied / "out"
    before = load_results(out)
    done = bench_here("rm", out, "--optimizer", "scatter", "--problem", "sphere-2", "--dry-run")
    assert "3 trials would be removed" in done.stdout
    assert len(load_results(out)) == 12
    assert "3 trials removed" in bench_here("rm", out, "--optimizer", "scatter", "--problem", "sphere-2").stdout
    left = load_results(out)
    assert len(left) == 9
    assert not ((left["optimizer"] == "scatter") & (left["problem"] == "sphere-2")).any()
    assert "3 trials removed" in bench_here("rm", out, "--failed").stdout
    assert load_results(out)["status"].eq("ok").all()
    run(Study.load(copied / "mixed.toml"), out, n_jobs=1)
    again = load_results(out)
    times = ["wall_s", "cpu_s", "objective_s", "memory_mb"]
    assert again.drop(columns=times).equals(before.drop(columns=times))


def test_a_dry_run_prints_the_plan_and_the_time_and_writes_nothing(bench_here, made):
    before = sorted((path.name, path.stat().st_mtime_ns) for path in (made / "out").iterdir())
    done = bench_here("run", made / "mixed.toml", "--output", made / "out", "--dry-run", "--trials", 1000, "--jobs", 2)
    assert done.returncode == 0
    assert (
        "2 problems x 2 optimizers x 1,000 trials = 4,000 runs of 30 evaluations, 9 of them already done" in done.stdout
    )
    assert "  faulty: 1997 to run" in done.stdout
    assert "with 2 jobs, estimated from the stored trials" in done.stdout
    fresh = bench_here("run", made / "mixed.toml", "--output", made / "fresh", "--dry-run", "--shard", "2/5")
    assert "shard 2/5 of them: 3 runs" in fresh.stdout
    assert "no duration can be estimated before trials are stored" in fresh.stdout
    assert not (made / "fresh").exists()
    assert sorted((path.name, path.stat().st_mtime_ns) for path in (made / "out").iterdir()) == before


@pytest.mark.slow
def test_shards_run_merge_and_verify_by_command(bench_here, made, tmp_path):
    for number in (1, 2):
        done = bench_here(
            "run", made / "mixed.toml", "--output", tmp_path / f"s{number}", "--shard", f"{number}/2", "--jobs", 1
        )
        assert "shard" in done.stdout
        assert not (tmp_path / f"s{number}" / "report.html").exists()  # of a part nothing can be claimed
    done = bench_here("merge", tmp_path / "s1", tmp_path / "s2", "-o", tmp_path / "all")
    assert done.returncode == 0
    assert f"12 trials in {tmp_path / 'all'}: 12 added, 0 held by more than one folder" in done.stdout
    done = bench_here("verify", tmp_path / "all", "--jobs", 1)
    assert done.returncode == 0
    assert "6 of 6 trials of 3 cells are the same bit by bit with 1 worker" in done.stdout
    assert "verified 20" in bench_here("status", tmp_path / "all").stdout


@pytest.mark.slow
def test_a_run_verifies_its_trials_before_the_report(bench_here, copied):
    out = copied / "out"
    command = ["run", copied / "mixed.toml", "--output", out, "--jobs", 1, "--trials", 3, "--verify", 1]
    done = bench_here(*command)  # faulty's trials fail again
    assert "3 of 3 trials of 3 cells are the same bit by bit" in done.stdout
    assert "3 of 3 trials of 3 cells are the same bit by bit" in (out / "tables" / "integrity.csv").read_text(
        encoding="utf-8"
    )
