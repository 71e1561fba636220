"""bench plan."""

import shutil

from bench import Study, run


def test_plan_prints_open_pairs_and_a_caution(bench_here, tmp_path):
    study = Study.from_dict(
        {"name": "s", "trials": 6, "seed": 3, "budget": 60, "problems": [{"name": "sphere-2"}],
         "optimizers": [{"name": "scatter"}, {"name": "scatter", "label": "other"}]}
    )  # fmt: skip
    run(study, tmp_path / "out", n_jobs=1)
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
