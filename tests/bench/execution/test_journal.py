"""The journal: an interrupted trial is made again, and nothing that was evaluated is evaluated twice."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rich.progress import Progress

from bench import FunctionProblem, load_results, run, solve
from bench.cli import export
from bench.cli.status import interrupted
from bench.execution.journal import Journal, best, journals, read, under_way_lines
from bench.execution.progress import Within
from bench.execution.side_by_side import evaluated
from bench.helpers.errors import PointError
from bench.storage.folder import Folder
from bench.storage.under_way import noting
from bench.trial.scoring import scored
from bench.trial.trial import Trial

TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb"]
KEY = {"problem": "p", "optimizer": "o", "trial": 0, "seed": 1, "budget": 9, "variables": ["x"]}
SIMULATOR = """
import os, sys, time
x, y = map(float, sys.argv[1:])
with open("COUNT", "a") as file:
    file.write(f"{x!r} {y!r}\\n")
if 1 < x < 1.5:
    os.abort()
if 1.5 < x < 1.7:
    time.sleep(600)
print((x - 1) ** 2 + y**2, 0.2 - y)
"""
STUDY = """
name = "night"
seed = 2
trials = 2
budget = 30
on_error = "worst"
journal = true
parallel = 2
LIMIT
[[problems]]
problem = ["PYTHON", "SIMULATOR"]
label = "simulator"
lower = [0, 0]
upper = [2, 1]
violations = 1
[[optimizers]]
name = "gwo"
agents = 6
"""


@pytest.fixture
def night(tmp_path):
    """Return a function that writes the study of a simulator, and the file of its evaluations."""

    def written(limit="", simulator=SIMULATOR):
        count = tmp_path / "count"
        (tmp_path / "simulator.py").write_text(simulator.replace("COUNT", str(count)))
        study = STUDY.replace("PYTHON", sys.executable).replace("SIMULATOR", str(tmp_path / "simulator.py"))
        (tmp_path / "study.toml").write_text(study.replace("LIMIT", limit))
        return tmp_path / "study.toml", count

    return written


def lines(count):
    return count.read_text().splitlines() if count.exists() else []


def same(a, b):
    pd.testing.assert_frame_equal(a.drop(columns=TIMES), b.drop(columns=TIMES), check_exact=True)


def killed(study, folder, count, after):
    """Run a study in a process, and kill that after so many evaluations."""
    code = f"import bench; bench.run({str(study)!r}, {str(folder)!r}, n_jobs=1, verify=False)"
    process = subprocess.Popen([sys.executable, "-c", code])
    patience = time.monotonic() + 300
    while len(lines(count)) < after and process.poll() is None and time.monotonic() < patience:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()


@pytest.mark.skipif(os.name != "posix", reason="programs are killed by signals")
def test_a_run_that_is_killed_goes_on_where_it_was(night, tmp_path):
    study, count = night(simulator=SIMULATOR.replace("1.5 < x < 1.7", "False"))
    run(study, tmp_path / "whole", n_jobs=1, verify=False)
    points = sorted(lines(count)[: 2 * 30])  # and the best point of each trial once more
    count.unlink()
    killed(study, tmp_path / "out", count, 25)
    (line,) = interrupted(Folder(tmp_path / "out"))
    assert line.endswith("of 1 interrupted trial are in the journal: 'bench run' goes on from there")
    outcome = run(study, tmp_path / "out", n_jobs=1, verify=False)
    assert [*interrupted(Folder(tmp_path / "out"))] == []
    assert outcome.journal["replayed"] > 0
    assert outcome.journal["dropped"] == 0
    assert [len(records) for _, records in journals(tmp_path / "out")] == [30, 30]
    same(load_results(tmp_path / "out"), load_results(tmp_path / "whole"))
    twice = len(lines(count)) - 2 * 30 - 2
    assert 0 <= twice <= 2 + 1  # what was under way: parallel = 2, and a best point
    assert {*points} <= {*lines(count)}


@pytest.mark.slow
def test_the_story_of_a_simulator_that_crashes_and_hangs(night, tmp_path):
    study, count = night('evaluation_timeout = "3 s"')
    killed(study, tmp_path / "out", count, 20)
    outcome = run(study, tmp_path / "out", n_jobs=1, verify=False)
    frame = load_results(tmp_path / "out")
    assert (outcome.failed, outcome.journal["dropped"], set(frame["stop"])) == (0, 0, {"budget"})
    assert (frame["failures"] > 0).any()
    assert (frame["violation"] <= 0).all()
    reasons = {each["error"] for _, records in journals(tmp_path / "out") for each in records if "error" in each}
    assert any("signal 6" in reason for reason in reasons)
    assert any("took more than 3 s" in reason for reason in reasons)
    assert sum(len(records) for _, records in journals(tmp_path / "out")) == 2 * 30


@pytest.mark.slow
def test_a_simulator_that_changed_answers_anew(night, tmp_path):
    study, count = night(simulator=SIMULATOR.replace("1.5 < x < 1.7", "False"))
    killed(study, tmp_path / "out", count, 15)
    night(simulator=SIMULATOR.replace("1.5 < x < 1.7", "False").replace("(x - 1) ** 2", "(x - 2) ** 2"))
    assert run(study, tmp_path / "out", n_jobs=1, verify=False).journal["replayed"] == 0


def counted(calls, by_point=True, broken=lambda x: False):
    def function(x):
        calls.append(np.array(x))
        if broken(x):
            raise ArithmeticError("it diverges")
        return (x**2).sum(axis=-1)

    return FunctionProblem(function, [-5], [5], vectorized=not by_point, name="p")


def journal(tmp_path, **settings):
    return Journal(tmp_path, KEY, {"name": "p"}, always=True, **settings)


@pytest.mark.parametrize("by_point", [True, False])
def test_the_same_points_are_answered_and_the_first_other_one_ends_that(tmp_path, by_point):
    x, calls = np.array([[1.0], [2.0], [3.0]]), []
    problem = counted(calls, by_point)
    with evaluated(problem, journal=journal(tmp_path)) as noted:
        first = noted.evaluate(x.copy()), noted.evaluate(x + 1)
    calls.clear()
    again = journal(tmp_path)
    with evaluated(problem, journal=again) as noted:
        assert noted.evaluate(x.copy()).tolist() == first[0].tolist()
        assert not calls
        assert noted.evaluate(x + 2).tolist() == [9.0, 16.0, 25.0]
        assert noted.evaluate(x.copy()).tolist() == [1.0, 4.0, 9.0]
    assert (again.replayed, again.dropped) == (3, 3)
    head, records = read(again.path)
    assert (head["optimizer"], [each["n"] for each in records]) == ("o", [*range(9)])
    assert best(records) == 1.0


def test_points_that_failed_are_not_evaluated_again_where_the_study_goes_on(tmp_path):
    x, calls = np.array([[1.0], [2.0], [3.0]]), []
    problem = scored(counted(calls, broken=lambda x: x[0] == 2), "death", "worst")
    for evaluations in (3, 0):
        calls.clear()
        with evaluated(problem, journal=journal(tmp_path)) as noted:
            assert noted.evaluate(x.copy()).tolist() == [1.0, np.inf, 9.0]
        assert len(calls) == evaluations
    with evaluated(problem, journal=journal(tmp_path, limit=5.0)) as noted:  # a longer one may be enough
        noted.evaluate(x.copy())
    assert len(calls) == 1
    failing = counted(calls, broken=lambda x: x[0] == 2)
    with pytest.raises(ArithmeticError), evaluated(failing, journal=journal(tmp_path)) as noted:
        noted.evaluate(x.copy())


def test_a_line_that_was_cut_counts_for_nothing(tmp_path):
    calls = []
    with evaluated(counted(calls), journal=journal(tmp_path)) as noted:
        noted.evaluate(np.array([[1.0], [2.0]]))
    path = journal(tmp_path).path
    path.write_bytes(path.read_bytes()[:-9])
    calls.clear()
    with evaluated(counted(calls), journal=journal(tmp_path)) as noted:
        assert noted.evaluate(np.array([[1.0], [2.0]])).tolist() == [1.0, 4.0]
    assert len(calls) == 1
    assert len(read(path)[1]) == 2


def test_processes_beside_note_each_point_as_it_is_known(tmp_path):
    x, marks = np.array([[1.0], [2.0], [3.0], [4.0]]), tmp_path / "marks"
    marks.mkdir()

    def function(x):
        Path(marks, f"{x[0]}-{len([*marks.iterdir()])}").touch()
        if x[0] == 3:
            os._exit(7)
        return float(x[0])

    problem = scored(FunctionProblem(function, [0], [9], vectorized=False), "death", "worst")
    for evaluations in (4, 4):
        with evaluated(problem, 2, journal=journal(tmp_path)) as noted:
            assert noted.evaluate(x.copy()).tolist() == [1.0, 2.0, np.inf, 4.0]
        assert len([*marks.iterdir()]) == evaluations


def test_fast_evaluations_are_not_noted(tmp_path):
    quick = Journal(tmp_path, KEY, {})
    with evaluated(counted([]), journal=quick) as noted:
        assert noted.evaluate(np.ones((2, 1))).tolist() == [1.0, 1.0]
    assert (quick.slow, quick.path.exists()) == (False, False)


def test_another_problem_s_journal_is_of_no_use(tmp_path):
    with evaluated(counted([]), journal=journal(tmp_path)) as noted:
        noted.evaluate(np.ones((2, 1)))
    assert Journal(tmp_path, KEY, {"name": "p"}).slow
    assert Journal(tmp_path, KEY, {"name": "q"}).slow is None


def test_points_that_a_kill_ended_are_evaluated_again(tmp_path):
    def function(x):
        raise PointError("the program beam ended by signal 15")

    problem = scored(FunctionProblem(function, [0], [9], vectorized=False), "death", "worst")
    with evaluated(problem, journal=journal(tmp_path)) as noted:
        noted.evaluate(np.ones((1, 1)))
    assert read(journal(tmp_path).path)[1] == []


def test_a_run_by_solve_goes_on_after_an_interruption(tmp_path):
    def tired(count, x, f, lowest):
        if count == 22:
            raise KeyboardInterrupt

    count, settings = tmp_path / "count", {"budget": 40, "seed": 3}

    def function(x):
        with count.open("a") as file:
            file.write("x\n")
        return float((x**2).sum())

    problem = FunctionProblem(function, [-5] * 2, [5] * 2, vectorized=False)
    problem.compiles = False
    whole = solve(problem, "cma-es", **settings)
    count.unlink()
    with pytest.raises(KeyboardInterrupt) as interrupted:
        solve(problem, "cma-es", on_evaluation=tired, output=tmp_path / "out", **settings)
    assert len(lines(count)) == 24  # whole generations
    so_far = interrupted.value.found
    assert (so_far.nfev, so_far.stop) == (24, "interrupted")
    assert so_far.fun == function(so_far.x)
    count.write_text("x\n" * 24)
    found = solve(problem, "cma-es", output=tmp_path / "out", **settings)
    assert (found.fun, found.x.tolist(), found.nfev) == (whole.fun, whole.x.tolist(), 40)
    assert len(lines(count)) == 40


def test_evaluations_are_exported_as_a_table(tmp_path):
    with evaluated(counted([]), journal=journal(tmp_path)) as noted:
        noted.evaluate(np.array([[1.0], [2.0]]))
    export.command(tmp_path, None, None, evaluations=True)
    table = pd.read_csv(tmp_path / "export" / "evaluations.csv")
    assert table[["evaluation", "x_x", "f"]].to_numpy().tolist() == [[1, 1.0, 1.0], [2, 2.0, 4.0]]
    assert table["optimizer"].tolist() == ["o", "o"]


def test_status_and_progress_count_the_evaluations_of_a_trial_under_way(tmp_path):
    with evaluated(counted([]), journal=journal(tmp_path)) as noted, noting(tmp_path, {}) as beside:
        noted.evaluate(np.array([[1.5], [2.0]]))
        assert [*under_way_lines(tmp_path, 1)] == []
        beside.begin(0, Trial("p", "o", 0, 1))
        (line,) = under_way_lines(tmp_path, 1)
        column = Within()
        column.folder = tmp_path
        assert "o on p, trial 0: 2 of 9 evaluations, best 2.25, about" in line
        with Progress(column) as progress:
            progress.add_task("all")
            assert str(column.render(progress.tasks[0])) == "under way: best 2.25 of 2 evaluations"
