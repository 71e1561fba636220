"""Programs as problems: the protocol, arguments, what fails, and the simulators of examples/simulator."""

import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench import BenchError, Study, load_problem, load_results, run
from bench.execution.side_by_side import evaluated
from bench.helpers.errors import PointError
from bench.trial.scoring import scored
from tests.problems.simulators import BOX, SIMULATORS, X

HEAD = """
import json, os, sys, time
print(json.dumps({"protocol": 1, "lower": [0, 0], "upper": [4, 4], **BOX}), flush=True)
for line in sys.stdin:
    x = json.loads(line)["x"]
    def answer(value): print(json.dumps({"f": value}), flush=True)
"""


def beam(x):
    height, width, ribs = x
    bend = 4e8 / (width * height**3 * (1 + ribs / 10))
    return 1e-3 * (2 * width * 5 + height * 3) + 0.2 * ribs + 10 * max(0, bend - 1)


@pytest.fixture
def program(tmp_path):
    """Return a function that returns the problem of a program in Python, from what it does with a point."""

    def made(deed="answer(x[0])", box="{}", head=HEAD, **options):
        path = tmp_path / "mine.py"
        path.write_text(head.replace("BOX", box) + f"    {deed}\n", encoding="utf-8")
        return load_problem(f"command:'{sys.executable}' '{path}'", **options)

    return made


@pytest.fixture(scope="session")
def simulator(tmp_path_factory):
    """Return the problem of an example."""

    def loaded(client):
        path = SIMULATORS / client
        if client.endswith(".sh"):
            return load_problem(f"command:{path}", **BOX)
        if client.endswith(".R"):
            if shutil.which("Rscript") is None:
                pytest.skip("Rscript is not installed")
            if subprocess.run(["Rscript", "-e", "loadNamespace('jsonlite')"]).returncode:
                pytest.skip("R's package jsonlite is not installed")
            return load_problem(f"command:Rscript {path}")
        compiler = shutil.which("cc")
        if compiler is None:
            pytest.skip("no C compiler is installed")
        made = tmp_path_factory.mktemp("simulator") / "beam"
        subprocess.run([compiler, "-O2", "-o", made, path, "-lm"], check=True)
        return load_problem(f"command:{made}")

    return loaded


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers that interrupt")
def test_a_program_is_not_blamed_for_an_answer_that_an_interrupt_left_unread(program):
    problem = program("time.sleep(0.6); answer(x[0])")
    problem.open()

    def interrupted():
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        problem.evaluate(np.ones((1, 2)))

    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            interrupted()
    finally:
        signal.signal(signal.SIGALRM, before)
    problem.close()


@pytest.mark.parametrize("client", ["beam.c", "beam.R", "beam.sh"])
def test_each_example_has_the_box_and_the_values_of_the_beam(simulator, client):
    problem = simulator(client)
    with evaluated(problem) as beside:
        values = beside.evaluate(X)
    assert (list(problem.variables), problem.integer.tolist()) == (BOX["variables"], BOX["integer"])
    assert (problem.lower.tolist(), problem.upper.tolist()) == (BOX["lower"], BOX["upper"])
    assert values == pytest.approx([beam(x) for x in X], rel=1e-14)


@pytest.mark.slow
def test_the_study_of_the_examples_runs_with_points_in_parallel(simulator, tmp_path, monkeypatch):
    problem = simulator("beam.c")
    shutil.copy(SIMULATORS / "beam.sh", tmp_path)
    shutil.copy(problem._command.words[0], tmp_path / "beam")
    monkeypatch.chdir(tmp_path)
    study = Study.load(SIMULATORS / "study.toml").override(trials=1, budget=60)
    assert not run(study, tmp_path / "out", n_jobs=1, verify=False).failed
    frame = load_results(tmp_path / "out")
    assert len(frame) == 4
    assert frame[["x_height", "x_width", "x_ribs"]].notna().all(axis=None)
    assert (frame["nfev"] == 60).all()


class TestConversation:
    def test_one_program_answers_for_as_long_as_a_trial_and_ends_with_it(self, program):
        problem = program("answer(os.getpid())")
        with evaluated(problem) as beside:
            first, again = beside.evaluate(np.ones((2, 2)))
            process = problem._talk[1]._process
        assert first == again == process.pid
        assert process.poll() is not None

    @pytest.mark.parametrize(
        ("deed", "reason"),
        [
            ("sys.exit('no licence')", "ended with code 1; it complained: no licence"),
            ("os.kill(os.getpid(), 9)", "ended by signal 9"),
            ("sys.exit()", "ended without an answer; wanted is a line of JSON"),
            ("print('hello', flush=True)", "wrote hello; wanted is a line of JSON"),
            ("answer('much')", "wrote {.*much.*}; wanted is"),
            ("answer(True)", "wrote .*true.*; wanted is"),
            ("answer(float('nan'))", "returned NaN"),
        ],
    )
    def test_a_point_that_fails_costs_no_other_one_and_its_reason_is_a_sentence(self, program, deed, reason):
        problem = program(f"answer(x[0]) if x[0] != 2 else {deed}")
        points = np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
        with evaluated(scored(problem, "death", "worst")) as beside:
            assert beside.evaluate(points).tolist() == [1.0, np.inf, 3.0]
            assert beside.failed == 1
        with evaluated(problem) as beside, pytest.raises(PointError, match=f"the program .*mine.py {reason}") as raised:
            beside.evaluate(points)
        assert "\n" not in str(raised.value)

    @pytest.mark.parametrize(
        "deed",
        [
            "answer(x[0]); answer(9)",
            "answer(9); answer(x[0])",
            "answer(x[0]) if x[0] < 3 else (answer(x[0]), answer(9))",
        ],
    )
    def test_a_line_more_than_asked_for_fails_the_trial(self, program, deed):
        problem = scored(program(deed), "death", "worst")
        more = r"wrote .* (unasked|after its last answer)"
        with pytest.raises(BenchError, match=more) as raised, evaluated(problem) as beside:
            beside.evaluate(np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]))
        assert "\n" not in str(raised.value)

    @pytest.mark.slow
    def test_a_point_that_hangs_fails_at_its_limit(self, program):
        problem = scored(program("time.sleep(600 if x[0] == 2 else 0); answer(x[0])"), "death", "worst")
        with evaluated(problem, 2, 2.0) as beside:
            assert beside.evaluate(np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])).tolist() == [1.0, np.inf, 3.0]

    @pytest.mark.parametrize(
        ("head", "reason"),
        [
            ("print('hello')", "wrote hello; wanted is a first line of JSON such as"),
            ("", "ended without a line; wanted is a first line"),
            ("import sys; sys.exit('no licence')", "ended with code 1; it complained: no licence"),
            ("""print('{"lower": [0], "upper": [1]}')""", 'must have "protocol": 1'),
            ("""print('{"protocol": 1, "lower": [0], "upper": [1], "names": ["a"]}')""", "has 'names'; "),
            ("""print('{"protocol": 1, "lower": [0], "upper": [1], "variables": 5}')""", "its box cannot be read"),
            ("import time; time.sleep(600)", "wrote nothing for 0.2 s; wanted is a first line"),
        ],
    )
    def test_what_is_no_first_line_is_one_sentence(self, program, head, reason, monkeypatch):
        if "sleep" in head:
            monkeypatch.setattr("problems.command.PATIENCE", 0.2)
        with pytest.raises(BenchError, match=reason) as raised:
            program("pass", head=f"{head}\nif True:\n")
        assert "\n" not in str(raised.value)


class TestOncePerPoint:
    @pytest.fixture
    def script(self, tmp_path):
        def made(text, words="", **options):
            path = tmp_path / "mine.sh"
            path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
            path.chmod(0o755)
            return load_problem(f"command:{path} {words}", **{"lower": [0, 0], "upper": [4, 4]} | options)

        return made

    def test_coordinates_follow_the_command_and_the_last_line_is_the_value(self, script):
        problem = script('echo "$@" > "$(dirname "$0")/seen"; echo converged; echo " 0.25 "; echo', "--case 3")
        assert problem.noiseless(np.array([[0.1, 2.0]])).tolist() == [0.25]
        assert (Path(problem._command.words[0]).parent / "seen").read_text() == "--case 3 0.1 2.0\n"

    @pytest.mark.parametrize(
        ("text", "reason"),
        [
            ("echo no mesh >&2; exit 3", "mine.sh ended with code 3; it complained: no mesh"),
            ("kill -9 $$", "mine.sh ended by signal 9"),
            ("echo done", "mine.sh printed done last; wanted is the value, as in 0.25"),
            ("echo 1_000", "mine.sh printed 1_000 last; wanted is the value"),
            ("echo nan", "mine.sh returned NaN"),
            ("true", "mine.sh printed nothing; wanted is the value, as in 0.25"),
        ],
    )
    def test_what_is_no_value_is_one_sentence(self, script, text, reason):
        with pytest.raises(PointError, match=reason):
            script(text).noiseless(np.ones((1, 2)))


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("command:./no-such", {}, "names no program that can be run"),
        ("command:'", {}, "is no command: No closing quotation"),
        ("command:{file}", {}, "cannot be executed: make it executable by 'chmod"),
        ("command:true", {"lowest": [0]}, "has no option 'lowest'; did you mean 'lower'"),
        ("command:true", {"folder": "no-such"}, "there is no folder 'no-such'"),
    ],
)
def test_what_cannot_be_run_is_one_sentence(tmp_path, name, options, reason):
    (tmp_path / "data.txt").write_text("1")
    with pytest.raises(BenchError, match=reason):
        load_problem(name.format(file=tmp_path / "data.txt"), **options)
