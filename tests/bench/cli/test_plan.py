"""bench plan, and what a run with looks prints."""

import shutil

import pytest

from bench import Study, run

STUDY = """
name = "looked"
budget = 150
seed = 5
looks = {trials = [12, 16]}
problems = [{name = "sphere-2"}]
optimizers = [{name = "scatter"}, {name = "scatter", label = "other"}, {name = "hill-climber"}]
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    place = tmp_path_factory.mktemp("plan")
    (place / "looked.toml").write_text(STUDY)
    return place


@pytest.mark.slow
def test_a_run_prints_what_each_look_decided_and_the_others_know_it(bench_here, place):
    done = bench_here("run", "looked.toml", "--output", "out", "--jobs", 1, "--no-report", cwd=place)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith(
        "study looked: 1 problem x 3 optimizers x at most 16 trials = 48 runs of 150 evaluations"
    )
    assert "looks at 12, 16 trials: 0 of 3 cells are decided" in lines
    assert "look at 12 trials: decided and stopped hill-climber on sphere-2; 1 of 3 cells is decided" in lines
    assert "look at 16 trials: 1 of 3 cells is decided" in lines
    assert "44 of 44 runs done" in lines
    status = bench_here("status", "out", cwd=place).stdout
    assert "looks at 12, 16 trials; cells decided: 1 at 12, of 3" in status
    assert [line.split()[:4] for line in status.splitlines() if line.startswith("hill")] == [
        ["hill-climber", "12", "0", "12"]
    ]
    dry = bench_here("run", "looked.toml", "--output", "out", "--dry-run", cwd=place).stdout
    assert "hill-climber: 0 to run" in dry
    packed = bench_here("pack", "out", "--output", "out.zip", cwd=place)
    assert "trials are missing" not in packed.stdout + packed.stderr


def test_plan_prints_open_pairs_and_a_caution(bench_here, tmp_path):
    study = Study.from_dict(
        {"name": "s", "trials": 6, "seed": 3, "budget": 60, "problems": [{"name": "sphere-2"}],
         "optimizers": [{"name": "scatter"}, {"name": "scatter", "label": "other"}]}
    )  # fmt: skip
    run(study, tmp_path / "out", jobs=1)
    before = {file.name for file in (tmp_path / "out").iterdir()}
    done = bench_here("plan", "out", cwd=tmp_path)
    assert done.returncode == 0
    first, *rest = done.stdout.splitlines()
    assert first.startswith("sphere-2: scatter and other, A12 0.")
    assert " of 6 trials: " in first
    assert rest[0].startswith("1 pair is not separated. With a power of 80%, ")
    assert "optional stopping" in rest[1]
    assert "power of 95%" in bench_here("plan", "out", "--power", 0.95, cwd=tmp_path).stdout
    assert {file.name for file in (tmp_path / "out").iterdir()} <= before | {"trials.sqlite-wal", "trials.sqlite-shm"}
    for power in (0, 1, 2, "nan"):
        assert bench_here("plan", "out", "--power", power, cwd=tmp_path).returncode == 2
    (tmp_path / "empty").mkdir()
    shutil.copy(tmp_path / "out" / "study.toml", tmp_path / "empty")
    for name, reason in (("empty", "no trials.sqlite"), ("nowhere", "holds no study.toml")):
        failed = bench_here("plan", name, cwd=tmp_path)
        assert failed.returncode == 2
        assert reason in failed.stderr
        assert failed.stderr.count("\n") == 1
