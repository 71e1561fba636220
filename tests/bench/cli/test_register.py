"""bench register writes the registration into the folder of the run, which then takes the run."""

from bench.storage.folder import REGISTRATION

STUDY = """
name = "s"
trials = 2
budget = 60
problems = [{name = "classical-sphere-d2-i1"}]
optimizers = [{name = "random-search"}, {name = "scatter"}]
"""


def test_a_study_is_registered_and_then_run_in_the_same_folder(bench_here, tmp_path):
    (tmp_path / "s.toml").write_text(STUDY)
    done = bench_here("register", "s.toml", cwd=tmp_path)
    assert done.stdout == f"registered in results/runs/s/{REGISTRATION}; run it with: bench run s.toml\n"
    ran = bench_here("run", "s.toml", "--jobs", 1, "--no-report", "--verify", 0, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "results" / "runs" / "s" / REGISTRATION).exists()


def test_a_study_that_cannot_run_is_not_registered(bench_here, tmp_path):
    (tmp_path / "s.toml").write_text(STUDY.replace("scatter", "no-such"))
    done = bench_here("register", "s.toml", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "unknown optimizer 'no-such'" in done.stderr
    assert not (tmp_path / "results").exists()
