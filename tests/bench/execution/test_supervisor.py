import numpy as np
import pytest

from bench.execution import supervisor as module
from bench.execution.answers import Box
from bench.execution.job import Task
from bench.execution.supervisor import Supervisor
from bench.execution.trial_process import as_answer
from bench.objective import Trace
from bench.sandbox.process import LostError, RemoteError
from bench.trial import Result, Trial


class Job:
    """Answers as processes would, on a sphere; ``evaluations`` has what was evaluated again, and whether anew."""

    evaluations: list[tuple[str, bool]]
    losses: int

    def __init__(self, *arguments, **options):
        pass

    def kill(self):
        pass

    def box(self, problem):
        return Box(("a", "b"), -np.ones(2), np.ones(2), np.zeros(2, bool))

    def prepare(self, trial):
        return self

    def before(self, problem):
        return 0

    def make(self, trial, server):
        x = np.array([0.5, 0.25])
        fun = float((x * x).sum()) - (trial.problem == "cheated")
        trace = Trace(np.array([1]), np.array([fun]))
        return as_answer(Result(x, fun, 7, trace, 0.0, 0.0, 0.0, "done", 0, {}, trial.seed)), 0.0

    def evaluate(self, problem, point, seconds, *, anew=False):
        self.evaluations.append((problem, anew))
        if Job.losses:
            Job.losses -= 1
            raise LostError("ended")
        if problem == "broken" or (problem == "once" and not anew):
            raise RemoteError("ZeroDivisionError")
        return {"fun": float(np.square(point).sum()), "spread": 0.0, "metrics": {}}


@pytest.fixture
def row(monkeypatch, small_study):
    """Make a trial on the problem named; return its row."""
    monkeypatch.setattr(module, "Job", Job)
    Job.evaluations = []

    def make(problem, losses=0):
        Job.losses = losses
        return Supervisor(Task(small_study)).make(Trial(problem, "optimizer", 0, 1))

    return make


def test_the_best_point_of_a_trial_is_evaluated_once(row):
    assert row("a")["status"] == "ok"
    assert Job.evaluations == [("a", False)]


def test_a_trial_that_claims_another_value_fails(row):
    found = row("cheated")
    assert found["status"] == "failed"
    assert "its best point has" in found["error"]
    assert Job.evaluations == [("cheated", False), ("cheated", True)]


def test_a_point_that_cannot_be_evaluated_fails(row):
    found = row("broken")
    assert found["status"] == "failed"
    assert "ZeroDivisionError" in found["error"]
    assert "evaluated again" in found["error"]


def test_a_new_evaluator_may_confirm_what_another_did_not(row):
    assert row("once")["status"] == "ok"
    assert Job.evaluations == [("once", False), ("once", True)]


def test_a_trial_whose_evaluator_is_lost_is_begun_once_more(row):
    assert row("a", losses=1)["status"] == "ok"
    assert row("a", losses=2)["status"] == "failed"
