"""bench run --matched, and every command on a folder that holds controls."""

import shutil

import pytest

from bench import load_results

STUDY = """
name = "mine"
trials = 2
budget = 60
[[problems]]
name = "sphere-2"
[[optimizers]]
name = "random-search"
agents = 9
handling = "box"
[[optimizers]]
name = "gwo"
agents = 9
"""


@pytest.fixture(scope="module")
def made(bench, tmp_path_factory):
    """A study's file, and its folder with controls; no test changes them."""
    place = tmp_path_factory.mktemp("matched")
    (place / "mine.toml").write_text(STUDY)
    done = bench("run", "mine.toml", "--output", "out", "--jobs", "1", "--no-report", "--matched", cwd=place)
    assert done.returncode == 0, done.stderr
    assert "2 optimizers and 2 controls x 2 trials = 8 runs" in done.stdout
    return place


def test_the_plan_has_the_controls(bench_here, made):
    done = bench_here("run", "mine.toml", "--output", "out", "--dry-run", "--matched", cwd=made)
    assert "2 optimizers and 2 controls x 2 trials = 8 runs of 60 evaluations, 8 of them already done" in done.stdout
    assert "  gwo (box): 0 to run" in done.stdout


@pytest.mark.slow
def test_a_study_of_equal_conditions_needs_none(bench_here, tmp_path):
    (tmp_path / "mine.toml").write_text(STUDY.replace('handling = "box"', ""))
    done = bench_here("run", "mine.toml", "--dry-run", "--matched", cwd=tmp_path)
    assert "no control is missing" in done.stdout
    assert "= 4 runs" in done.stdout


def test_every_command_takes_the_folder(bench_here, made, tmp_path):
    shutil.copytree(made / "out", tmp_path / "out")
    assert [line.split()[:4] for line in bench_here("status", "out", cwd=tmp_path).stdout.splitlines()[3:7]] == [
        ["random-search", "2", "0", "2"], ["gwo", "2", "0", "2"],
        ["gwo", "(box)", "2", "0"], ["random-search", "(repair)", "2", "0"],
    ]  # fmt: skip
    for kind in ("csv", "ioh"):
        done = bench_here("export", "out", "--format", kind, "--output", kind, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        left = "controls are not compared with the optimizers: 4 trials of gwo (box), random-search (repair)"
        assert left in done.stdout + done.stderr
        assert left in (tmp_path / kind / "README.txt").read_text()
    assert len(load_results(tmp_path / "out")) == 4
    assert bench_here("pack", "out", cwd=tmp_path).returncode == 0
    assert bench_here("unpack", "out.zip", "--output", "again", cwd=tmp_path).returncode == 0
    done = bench_here("merge", "again", "out", "--output", "both", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    done = bench_here("rm", "both", "--optimizer", "gwo (box)", cwd=tmp_path)
    assert "2 trials removed" in done.stdout


@pytest.mark.slow
def test_controls_are_made_again_and_compared(bench, made, tmp_path):
    shutil.copytree(made / "out", tmp_path / "out")
    done = bench("verify", "out", "--trials", "1", cwd=tmp_path)
    assert "4 of 4 trials of 4 cells are the same bit by bit" in done.stdout
