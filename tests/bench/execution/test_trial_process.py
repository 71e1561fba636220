"""The functions that are called in the processes of a run, called here."""

import numpy as np
import pytest

from bench import FunctionProblem
from bench.errors import ProblemError
from bench.execution import trial_process


@pytest.fixture
def problem(monkeypatch):
    """Return a function that puts a problem of this function into the place of every one."""

    def put(function):
        problem = FunctionProblem(function, [-1.0] * 2, [1.0] * 2)
        monkeypatch.setattr(trial_process, "_problem", lambda label: problem)

    return put


def test_a_point_is_evaluated_alone_unless_batches_are_asked_for(problem):
    sizes = []
    problem(lambda x: sizes.append(len(x)) or x.sum(axis=1))
    found = {"fun": 0.75, "metrics": {}, "spread": 0.0, "noise": 0.0}
    assert trial_process.evaluate("any", [0.5, 0.25], False) == found
    assert sizes == [1]
    assert trial_process.evaluate("any", [0.5, 0.25], True) == found
    assert len(sizes) > 3


def test_values_that_depend_on_their_batch_spread(problem):
    problem(lambda x: x.sum(axis=1) + np.arange(len(x)) / 1024)
    assert trial_process.evaluate("any", [0.5, 0.25], True)["spread"] == 31 / 1024


def test_a_problem_that_writes_into_its_points_moves_none(problem):
    def write(x):
        values = x.sum(axis=1)
        x[:] = 0.0
        return values

    problem(write)
    assert trial_process.evaluate("any", [0.5, 0.25], True) == {"fun": 0.75, "metrics": {}, "spread": 0.0, "noise": 0.0}


def test_what_the_problem_raises_at_a_best_point_is_its_own_error(problem):
    def fail(x):
        raise ZeroDivisionError("no mass")

    problem(fail)
    with pytest.raises(ProblemError, match="ZeroDivisionError: no mass"):
        trial_process.evaluate("any", [0.5, 0.25], False)
