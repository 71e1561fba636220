"""bench plan."""

from bench import Study, run

STUDY = {
    "name": "s", "trials": 6, "budget": 60, "problems": [{"name": "sphere-2"}],
    "optimizers": [{"name": "scatter"}, {"name": "scatter", "label": "other"}],
}  # fmt: skip
SHOWN = "The smallest A12 that it shows with a power of 80%: on a problem "


def test_plan_prints_the_gap_that_trials_show_and_the_trials_that_a_gap_needs(bench_here, tmp_path):
    run(Study.from_dict(STUDY), tmp_path / "out", n_jobs=1)
    before = {file.name for file in (tmp_path / "out").iterdir()}
    done = bench_here("plan", "out", cwd=tmp_path)
    assert done.returncode == 0
    design, shown, needed, answer, *_ = done.stdout.splitlines()
    assert design == "The design: 2 optimizers, 1 problem, 6 trials of each on a problem."
    assert shown.startswith(SHOWN)
    assert needed.startswith("Trials of each on a problem that an A12 of 0.71 needs: on a problem ")
    assert {file.name for file in (tmp_path / "out").iterdir()} <= before | {"trials.sqlite-wal", "trials.sqlite-shm"}
    assert answer.endswith("on sphere-2.")  # what its results say now
    assert bench_here("plan", "out/study.toml", cwd=tmp_path).stdout.splitlines() == [design, shown, needed]
    asked = bench_here("plan", "out", "--power", 0.95, "--gap", 0.9, cwd=tmp_path).stdout
    assert "power of 95%" in asked
    assert "an A12 of 0.9 needs" in asked
