"""The command tune, from the training to the report of the study that it writes."""

import tomllib

import pytest

from bench.cli.tune import gained
from bench.study.tuned import Tuned
from bench.tuning.tune import Best

AGENTS = ("--condition", "agents")
TRAIN = ("--train", "sphere-3", "--test", "sphere-2")


CORNER = """
from dataclasses import dataclass

from bench import Optimizer, parameter


@dataclass(frozen=True)
class Corner(Optimizer):
    width: float = parameter(1e-9, minimum=0, tune=(0.5, 1.0))

    def minimize(self, objective, rng):
        while True:
            points = self.width * rng.random((5, objective.dimension))
            objective(objective.lower + points * (objective.upper - objective.lower))
"""
"""An optimizer whose defaults search a corner of the box alone: whatever tuning tries is better."""

SIZES = ("--configurations", "4", "--trials", "1", "--budget", "60", "--jobs", "1")


def test_it_writes_a_study_that_runs_and_reports_what_tuning_gained(bench_here, tmp_path):
    (tmp_path / "corner.py").write_text(CORNER)
    command = ("tune", "corner.py:Corner", *TRAIN, *SIZES)
    first = bench_here(*command, cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "corner.py:Corner: width 1e-09 to 1" in first.stdout
    assert "4 configurations of each optimizer, 1 trial on each of 1 training problem" in first.stdout
    assert "study: tuned.toml; test it with: bench run tuned.toml" in first.stdout
    written = (tmp_path / "tuned.toml").read_text()
    assert bench_here(*command, cwd=tmp_path).returncode == 0
    assert (tmp_path / "tuned.toml").read_text() == written
    done = bench_here("run", "tuned.toml", "--trials", "6", "--jobs", "1", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    frozen = tomllib.loads((tmp_path / "results/runs/tuned/study.toml").read_text())
    assert frozen["tuning"] == tomllib.loads(written)["tuning"]
    page = (tmp_path / "results/runs/tuned/report.html").read_text()
    assert "What tuning gained" in page
    assert "Akiba et al., 2019" in page
    assert "No problem of this report was tuned on." in page
    refused = bench_here("run", "tuned.toml", "--problem", "sphere-3", cwd=tmp_path)
    assert refused.returncode == 2
    assert "were tuned on 'sphere-3', so it cannot be a test problem" in refused.stderr


def test_a_tuning_that_found_nothing_says_so_and_writes_no_study(bench_here, tmp_path):
    done = bench_here("tune", "scatter", *TRAIN, *AGENTS, *SIZES, cwd=tmp_path)  # whose agents change no point
    assert done.returncode == 0, done.stderr
    last = done.stdout.splitlines()[-2:]
    assert last[0].endswith("and nothing tried is better")
    assert last[1] == "no study is written, as it would compare the defaults with themselves"
    assert not (tmp_path / "tuned.toml").exists()


@pytest.mark.parametrize(
    ("scores", "options", "said"),
    [([0.7596, 0.8], {}, "1 - AOCC 0.7596 by default, and nothing tried is better"),
     ([0.7596, 0.75], {"agents": 7}, "1 - AOCC 0.7596 by default, 0.75 with agents=7")],
)  # fmt: skip
def test_what_was_gained_is_not_the_defaults_beside_themselves(scores, options, said):
    record = Tuned("scatter", "a", "a", {}, {"agents": [30, 7]}, scores, [1, 1], 0, 120, 1.0)
    assert gained(Best(record, options), "1 - AOCC").endswith(said)


@pytest.mark.slow  # the sentence itself is tested with the studies and with the section
def test_a_record_of_the_tuning_that_was_edited_or_deleted_is_believed_nowhere(bench_here, tmp_path):
    (tmp_path / "corner.py").write_text(CORNER)
    assert bench_here("tune", "corner.py:Corner", *TRAIN, *SIZES, cwd=tmp_path).returncode == 0
    written = (tmp_path / "tuned.toml").read_text()
    (tmp_path / "tuned.toml").write_text(written.replace('train = [\n    "sphere-3"', 'train = [\n    "sphere-4"'))
    edited = bench_here("run", "tuned.toml", "--trials", "6", "--jobs", "1", "--output", "edited", cwd=tmp_path)
    assert edited.returncode == 0, edited.stderr
    assert "does not fit its hash: it was edited" in " ".join((edited.stdout + edited.stderr).split())
    page = (tmp_path / "edited/report.html").read_text()
    assert "not tuned on" not in page
    assert "was tuned on." not in page
    assert "The record of the tuning does not fit its hash" in page
    (tmp_path / "tuned.toml").write_text(written[: written.index("[tuning]")])
    deleted = bench_here("run", "tuned.toml", "--trials", "6", "--jobs", "1", "--output", "deleted", cwd=tmp_path)
    assert deleted.returncode == 0, deleted.stderr
    page = (tmp_path / "deleted/report.html").read_text()
    assert "not tuned on" not in page
    assert "was tuned on." not in page


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (
            ("scatter", *TRAIN, "--configurations", "0"),
            "--configurations must be a whole number from 1 to 1000000, not 0",
        ),
        (("scatter", *TRAIN, "--timeout", "0"), "--timeout must be a positive number of seconds"),
        (("scatter", *TRAIN, "--objective", "mean"), "--objective must be aocc or regret, not 'mean'"),
        (
            ("scatter", *TRAIN, "--condition", "weather"),
            "'weather' is no condition; the conditions are agents, handling",
        ),
        (
            ("cma-es", *TRAIN, "--set", "agents=9", "--condition", "agents"),
            "no optimizer here has the condition 'agents'",
        ),
        (("scatter", *TRAIN, "--output", "mine.txt"), "must end with .toml"),
        (
            ("scatter", *TRAIN, *AGENTS, "--output", "own.toml"),
            "is no study that 'bench tune' wrote; give another --output",
        ),
        (("scatter", *TRAIN, "--set", "wings=2"), "has no parameter 'wings'"),
    ],
)
def test_bad_input_costs_one_sentence(bench_here, tmp_path, arguments, reason):
    own = 'name = "own"\nproblems = [{name = "sphere-2"}]\noptimizers = [{name = "scatter"}]\n'
    (tmp_path / "own.toml").write_text(own)
    done = bench_here("tune", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert reason in done.stderr
    assert (tmp_path / "own.toml").read_text() == own
    assert not (tmp_path / "tuned.toml").exists()
