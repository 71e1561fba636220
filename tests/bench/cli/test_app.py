"""The command line as a stranger uses it: what it prints, and one sentence and an exit code for wrong input."""

import json
import subprocess
import sys

import pytest

STUDY = """
name = "tiny"
trials = 2
budget = 40

[[problems]]
names = ["sphere-2", "sphere-3"]

[[optimizers]]
name = "scatter"

[[optimizers]]
name = "{second}"
"""


@pytest.fixture
def tiny(tmp_path):
    path = tmp_path / "tiny.toml"
    path.write_text(STUDY.format(second="hill-climber"))
    return path


def test_run_writes_a_report_and_status_knows_it(bench, bench_here, tiny, tmp_path):
    done = bench("run", tiny, "--output", tmp_path / "out", "--jobs", 1)
    assert done.returncode == 0, done.stderr
    assert "2 problems x 2 optimizers x 2 trials = 8 runs of 40 evaluations" in done.stdout
    assert "8 of 8 runs done" in done.stdout
    for name in ("study.toml", "trials.sqlite", "environment.json", "report.html"):
        assert (tmp_path / "out" / name).stat().st_size > 0
    again = bench_here("run", tiny, "--output", tmp_path / "out", "--jobs", 1, "--no-report")
    assert "8 of them already done" in again.stdout
    answer = json.loads((tmp_path / "out" / "answer.json").read_text())
    assert answer["sentence"] in again.stdout.replace("\n", " ")
    status = bench_here("status", tmp_path / "out")
    assert status.returncode == 0
    assert "scatter       4     0       4" in status.stdout


def test_a_part_of_a_run_imports_nothing_that_only_a_report_needs(tiny, tmp_path):
    code = "import sys\nfrom bench.cli.app import main\ntry:\n    main()\nfinally:\n"
    code += "    print(*{'pandas', 'scipy.stats', 'matplotlib'} & {*sys.modules}, file=sys.stderr)"
    command = [sys.executable, "-c", code, "run", tiny, "--output", tmp_path / "out", "--jobs", "1", "--shard", "1/2"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "4 of 4 runs done" in done.stdout
    assert done.stderr.split() == []


def test_failed_trials_are_said_and_end_with_one(bench_here, tmp_path):
    path = tmp_path / "faults.toml"
    path.write_text(STUDY.format(second="faulty"))
    done = bench_here("run", path, "--output", tmp_path / "out", "--jobs", 1)
    assert done.returncode == 1
    assert "failed: faulty on sphere-2, trial 0: RuntimeError: cannot do planes" in done.stdout
    assert "2 trials failed" in done.stderr
    assert (tmp_path / "out" / "report.html").exists()


def test_a_file_imports_what_lies_beside_it_and_no_command_anything_else_of_the_working_folder(bench_here, shadows):
    (shadows / "tiny.toml").write_text(STUDY.format(second="beside.py:stroll"))
    for arguments in (
        ("solve", "beside.py:ball", "beside.py:stroll", "--budget", 40),
        ("run", "tiny.toml", "-o", "out", "--problem", "beside.py:ball", "--jobs", 1, "--no-report"),
    ):
        done = bench_here(*arguments, cwd=shadows)
        assert done.returncode == 0, done.stderr
    assert not [*shadows.glob("*.imported")]


def test_solve_prints_the_point_and_the_figures(bench_here):
    done = bench_here("solve", "sphere-3", "hill-climber", "--budget", 300, "--seed", 4, "--set", "sigma=0.1")
    assert done.returncode == 0
    for word in ("best value", "x3", "radius", "300 (stopped by: budget)"):
        assert word in done.stdout


def test_the_help_has_panels_and_plug_ins_name_theirs(bench_here):
    help_ = bench_here("--help").stdout
    panels = {}
    for line in help_.splitlines():
        if line.startswith("╭─ "):
            rows = panels.setdefault(line.strip("╭─╮ "), [])
        elif line.startswith("│ ") and line[2] != " ":
            rows.append(line.split()[1])
    assert list(panels) == ["Options", "Run", "Read", "Check", "Share", "Backlash"]
    assert set(panels["Backlash"]) == {"calibrate", "data", "estimate", "simulate"}
    assert "pack" in panels["Share"]


@pytest.mark.slow
def test_a_run_names_the_optimizers_that_stop_without_a_declared_reason(bench_here, tiny, tmp_path):
    (tmp_path / "lazy.py").write_text(
        "def three(objective, rng):\n    objective(rng.random((3, objective.dimension)))\n"
    )
    options = ("--output", tmp_path / "out", "--jobs", 1, "--no-report")
    done = bench_here("run", tiny, *options, "--optimizer", tmp_path / "lazy.py:three")
    line = "trials that ended before the budget without a declared reason: three (4)"
    remedy = 'loop until the budget ends the run, or call objective.stop("reason")'
    assert (done.returncode, done.stderr) == (1, f"bench: {line}; {remedy}\n")
    again = bench_here("run", tiny, *options, "--optimizer", tmp_path / "lazy.py:three")
    assert (again.returncode, again.stderr) == (1, done.stderr)
    assert line in bench_here("status", tmp_path / "out").stdout.splitlines()
    assert "declared" not in bench_here("run", tiny, "--output", tmp_path / "all", *options[2:]).stderr


def test_python_m_bench_imports_nothing_of_the_working_folder(bench, shadows):
    (shadows / "bench.py").unlink()  # which Python itself would run in its place
    assert bench("--version", cwd=shadows).stdout.startswith("backlash-bench ")
    assert not [*shadows.glob("*.imported")]


def test_the_script_of_a_shell_s_completion_is_printed_without_a_complaint(bench_here, monkeypatch):
    monkeypatch.setattr("shellingham.detect_shell", lambda *_, **__: ("bash", "/bin/bash"))
    done = bench_here("--show-completion")
    assert (done.returncode, done.stderr) == (0, "")
    assert "complete -o default" in done.stdout
