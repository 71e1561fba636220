"""The functions that are called in the processes of a run, called here."""

import pytest

from bench import FunctionProblem
from bench.execution import trial_process
from bench.helpers.errors import PROBLEM_FAILED
from bench.sandbox.side_effects import reset_random
from bench.trial.trial import Trial


@pytest.fixture
def confirmed(monkeypatch, small_study):
    """Return a function that makes a trial on any problem, and then returns what confirms it."""
    trial_process.begin(small_study, {}, "", {})
    reset_random()  # as a process of its own begins, whatever other tests left
    label = small_study.optimizers[0].label

    def confirm(problem):
        monkeypatch.setattr(trial_process, "_problem", lambda label: problem)
        assert "error" not in trial_process.make(Trial("any", label, 0, 1))
        return trial_process.confirm("any")

    return confirm


def problem(function=lambda x: (x**2).sum(axis=1), describe=lambda x: {"norm": abs(x).sum()}):
    made = FunctionProblem(function, [-1.0] * 2, [1.0] * 2)
    made.describe = describe
    return made


def test_the_best_point_is_described_once_its_value_is_confirmed(confirmed):
    (name,) = confirmed(problem())["metrics"]
    assert name == "norm"


@pytest.mark.parametrize("metrics", [None, 5, {"norm": "wide"}, {"norm": None}])
def test_metrics_that_are_no_numbers_are_the_problem_s_error(confirmed, metrics):
    assert confirmed(problem(describe=lambda x: metrics))["error"].startswith(PROBLEM_FAILED)
