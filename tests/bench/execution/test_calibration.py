"""How long a study takes, from short trials."""

from dataclasses import replace

import pytest

from bench import Study, run
from bench.execution.calibration import LEAST, SHARE, estimated
from bench.execution.runner import plan
from bench.study.entries import Entry


def study(budget, problems=("sphere-2", "sphere-3"), optimizers=("scatter", "early"), **changes):
    return Study.from_dict(
        {"name": "s", "trials": 2, "budget": budget, "problems": [{"names": list(problems)}],
         "optimizers": [{"names": list(optimizers)}]} | changes
    )  # fmt: skip


@pytest.mark.parametrize(
    ("budget", "short"),
    [(60, 60), (LEAST, LEAST), (100_000, 5_000), ("1e5 * d", "5000 * d"), ("50 * d", "50 * d"),
     ({"2": 200_000, "3": 60}, {"2": 10_000, "3": 60})],
)  # fmt: skip
def test_a_short_trial_has_a_part_of_a_large_budget(budget, short):
    assert study(budget).budget.shortened(SHARE, LEAST) == short


@pytest.mark.slow
def test_it_counts_every_missing_trial_by_its_evaluations(tmp_path, testing_plugins):
    few = estimated(plan(study(60), tmp_path / "a"), 1).seconds
    many = estimated(plan(study(60, trials=2000), tmp_path / "b"), 1).seconds
    assert 0 < few < many
    assert not list(tmp_path.iterdir())


def test_without_a_short_trial_that_succeeds_there_is_none(tmp_path, testing_plugins):
    lost = study(60, problems=("sphere-2",), optimizers=("hostile",))
    assert estimated(plan(lost, tmp_path / "a"), 1).seconds is None


@pytest.mark.slow
def test_a_search_without_an_end_is_stopped(tmp_path, testing_plugins, monkeypatch):
    monkeypatch.setattr("bench.execution.calibration.LONGEST", 1.0)
    monkeypatch.setattr("bench.execution.job.WARMING", 1.0)
    endless = replace(study(60, problems=("sphere-2",)), optimizers=(Entry("hostile", "hostile", {"deed": "spin"}),))
    assert estimated(plan(endless, tmp_path / "a"), 1).seconds is None


COUNTED = """
import os, time, bench
def fun(x):
    with open(os.environ["COUNTED"], "a") as file:
        file.write("x" * len(x))
    time.sleep(PAUSE)
    return (x**2).sum(axis=1)
mine = bench.FunctionProblem(fun, [-1.0] * 2, [1.0] * 2, name="mine", vectorized=True)
"""


@pytest.fixture
def counted(tmp_path, monkeypatch):
    """Return a study of a problem that takes a while, and a function that returns the evaluations so far."""
    monkeypatch.setenv("COUNTED", str(tmp_path / "evaluations"))

    def made(pause=0.0, **changes):
        (tmp_path / "mine.py").write_text(COUNTED.replace("PAUSE", str(pause)), encoding="utf-8")
        return study(30, problems=(f"{tmp_path / 'mine.py'}:mine",), optimizers=("random-search",), **changes)

    def evaluations():
        file = tmp_path / "evaluations"
        return len(file.read_text()) if file.exists() else 0

    return made, evaluations


def test_a_run_makes_one_evaluation_more_a_trial(tmp_path, counted):
    made, evaluations = counted
    run(made(), tmp_path / "out", n_jobs=1, verify=False)
    assert evaluations() == 2 * (30 + 1)


def test_no_trial_is_made_again_where_an_evaluation_takes_long(tmp_path, counted, monkeypatch):
    made, evaluations = counted
    monkeypatch.setattr("bench.execution.again.EXPENSIVE", 1e-9)
    assert run(made(), tmp_path / "out", n_jobs=1).spared == ["random-search"]
    assert evaluations() == 2 * (30 + 1)


def test_a_dry_run_evaluates_twice_where_an_evaluation_takes_more_than_a_millisecond(tmp_path, counted):
    made, evaluations = counted
    found = estimated(plan(made(pause=0.01, trials=100), tmp_path / "a"), 1)
    assert found.seconds >= 101 * 30 * 0.01
    assert found.source.endswith("s an evaluation, in 2 evaluations on some of the problems")
    assert evaluations() == 2


def test_a_dry_run_ends_an_evaluation_that_takes_a_second(tmp_path, counted, monkeypatch):
    made, evaluations = counted
    monkeypatch.setattr("bench.execution.calibration.EXPENSIVE", 0.3)
    found = estimated(plan(made(pause=600), tmp_path / "a"), 1)
    assert found.seconds is None
    assert found.source.endswith("takes more than 0.3 s, so it was ended and no other was made")
    assert evaluations() == 1


def test_a_problem_that_fails_is_named(tmp_path, counted):
    made, _ = counted
    broken = made(pause="[]")
    assert "failed: " in estimated(plan(broken, tmp_path / "a"), 1).source
