"""The command line as a stranger uses it: what it prints, and one sentence and an exit code for wrong input."""

import subprocess
import sys

import pytest
import typer

from bench.cli.app import app
from bench.storage.folder import Folder

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
    status = bench_here("status", tmp_path / "out")
    assert status.returncode == 0
    assert "scatter       4     0       4" in status.stdout


def test_a_run_without_a_report_imports_nothing_that_only_a_report_needs(tiny, tmp_path):
    code = "import sys\nfrom bench.cli.app import main\ntry:\n    main()\nfinally:\n"
    code += "    print(*{'pandas', 'scipy.stats', 'matplotlib'} & {*sys.modules}, file=sys.stderr)"
    command = [sys.executable, "-c", code, "run", tiny, "--output", tmp_path / "out", "--jobs", "1", "--no-report"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "8 of 8 runs done" in done.stdout
    assert done.stderr.split() == []


def test_failed_trials_are_said_and_end_with_one(bench_here, tmp_path):
    path = tmp_path / "faults.toml"
    path.write_text(STUDY.format(second="faulty"))
    done = bench_here("run", path, "--output", tmp_path / "out", "--jobs", 1)
    assert done.returncode == 1
    assert "failed: faulty on sphere-2, trial 0: RuntimeError: cannot do planes" in done.stdout
    assert "2 trials failed" in done.stderr
    assert (tmp_path / "out" / "report.html").exists()


def test_the_default_output_is_named_after_the_study(bench_here, tiny, tmp_path):
    assert bench_here("run", tiny, "--jobs", 1, "--no-report", cwd=tmp_path).returncode == 0
    assert (tmp_path / "results" / "runs" / "tiny" / "trials.sqlite").exists()


def test_python_m_bench_imports_nothing_of_the_working_folder(bench, shadows):
    (shadows / "bench.py").unlink()  # which Python itself would run in its place
    assert bench("--version", cwd=shadows).stdout.startswith("backlash-bench ")
    assert not [*shadows.glob("*.imported")]


def test_a_file_imports_what_lies_beside_it_and_no_command_anything_else_of_the_working_folder(bench_here, shadows):
    (shadows / "tiny.toml").write_text(STUDY.format(second="beside.py:stroll"))
    for arguments in (
        ("solve", "beside.py:ball", "beside.py:stroll", "--budget", 40),
        ("run", "tiny.toml", "-o", "out", "--problem", "beside.py:ball", "--jobs", 1, "--no-report"),
    ):
        done = bench_here(*arguments, cwd=shadows)
        assert done.returncode == 0, done.stderr
    assert not [*shadows.glob("*.imported")]


@pytest.mark.slow
def test_nor_do_verify_and_check(bench_here, shadows):
    (shadows / "tiny.toml").write_text(STUDY.format(second="beside.py:stroll"))
    bench_here("run", "tiny.toml", "-o", "out", "--jobs", 1, "--no-report", cwd=shadows)
    assert bench_here("verify", "out", "--trials", 1, "--jobs", 1).returncode == 0
    done = bench_here("check", "beside.py:stroll", "--no-bias", cwd=shadows)
    assert "passed: beside.py:stroll, processes" in done.stdout
    assert not [*shadows.glob("*.imported")]


def test_list_names_everything(bench):
    done = bench("list", COLUMNS="200")
    assert done.returncode == 0
    for name in ("cma-es", "gwo", "hill-climber", "broken", "signature", "recording", "thesis", "simulate"):
        assert name in done.stdout


def test_solve_prints_the_point_and_the_figures(bench_here):
    done = bench_here("solve", "sphere-3", "hill-climber", "--budget", 300, "--seed", 4, "--set", "sigma=0.1")
    assert done.returncode == 0
    for word in ("best value", "x3", "radius", "300 (stopped by: budget)"):
        assert word in done.stdout


def test_solve_prints_the_value_without_noise_of_a_noisy_problem(bench_here):
    done = bench_here("solve", "bbob-noisy-f110-d2-i1", "random-search", "--budget", "60")
    assert "best value, without noise" in done.stdout


def test_simulate_writes_a_recording_that_can_be_fitted(bench_here, tmp_path):
    assert bench_here("simulate", tmp_path / "a.csv", "--level", 12).returncode == 0
    done = bench_here("solve", f"recording:{tmp_path / 'a.csv'}", "gwo", "--set", "agents=100", "--budget", 20000)
    assert done.returncode == 0
    assert "backlash_rad" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["runn"], "No such command 'runn'"),
        (["run"], "name a study: 'bench run quick' runs a small one"),
        (["run", "quick", "--jobs", "x"], "--jobs must be a whole number, not 'x'"),
        (
            ["solve", "sphere-2", "scatter", "--budget", "lots"],
            "--budget must be a whole number from 1 to 1e+15",
        ),
        (["run", "quick", "--backend", "nope"], "unknown backend 'nope'"),
        (["run", "quick", "--jobs", "0"], "--jobs must be a whole number from 1 to 1000, or -1 for every"),
        (["run", "quick", "--output", "/proc/nothing/here"], "the output folder /proc/nothing/here cannot be written"),
        (["solve", "signature-12", "gwp"], "unknown optimizer 'gwp'; did you mean 'gwo'?"),
        (["solve", "signature-99", "gwo"], "unknown problem 'signature-99'"),
        (["solve", "rastrigin", "gwo"], "did you mean 'classical-rastrigin-d2-i1', 'classical-rastrigin-d3-i1' or "),
        (["solve", "qwz", "gwo"], "unknown problem 'qwz'; the families are bbob, "),
        (["solve", "signature-12", "gwo", "--set", "agents"], "'agents' is not KEY=VALUE"),
        (
            ["list", "optimisers"],
            "no kind, family, suite or plug-in is called 'optimisers'; did you mean 'optimizers'?",
        ),
        (["report", "."], "holds no study.toml"),
        (["status", "nowhere"], "holds no study.toml"),
        (["simulate", "/proc/a.csv", "--level", "3"], "cannot be written"),
    ],
)
def test_wrong_input_is_one_sentence_and_exit_code_two(bench_here, arguments, said, tmp_path):
    done = bench_here(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.startswith("bench: ")
    assert done.stderr.count("\n") == 1


def test_without_arguments_the_help_alone_is_printed(bench_here):
    done = bench_here()
    assert "Usage: bench" in done.stdout
    assert done.stderr == ""


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


def test_a_budget_of_solve_may_follow_the_dimension(bench_here):
    done = bench_here("solve", "sphere-3", "hill-climber", "--budget", "20 * d")
    assert "60 (stopped by: budget)" in done.stdout


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


def test_files_that_are_no_study(bench_here, tmp_path):
    (tmp_path / "bad.toml").write_text("name = ")
    assert "is not valid TOML" in bench_here("run", tmp_path / "bad.toml").stderr
    (tmp_path / "odd.toml").write_text(STUDY.format(second="hillclimber"))
    done = bench_here("run", tmp_path / "odd.toml")
    assert done.returncode == 2
    assert "unknown optimizer 'hillclimber'; did you mean 'hill-climber'?" in done.stderr


@pytest.mark.slow
def test_another_budget_is_named_and_the_trials_before_are_kept(bench_here, tiny, tmp_path):
    bench_here("run", tiny, "--output", tmp_path / "out", "--jobs", 1, "--no-report")
    trials = Folder(tmp_path / "out").store.trials()
    done = bench_here("run", tiny, "--output", tmp_path / "out", "--budget", 50, "--dry-run")
    assert f"evaluations changed from 40 to 50: {sum(trials.values())} trials to make" in done.stdout
    assert Folder(tmp_path / "out").store.trials() == trials


def test_every_command_with_an_output_takes_o_for_it():
    options = {name: [*each.params] for name, each in typer.main.get_command(app).commands.items()}
    outputs = {name: each.opts for name, given in options.items() for each in given if "--output" in each.opts}
    assert {"run", "report"} <= set(outputs)
    assert [name for name, opts in outputs.items() if "-o" not in opts] == []
