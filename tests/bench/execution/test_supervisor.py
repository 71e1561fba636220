import numpy as np
import pytest

from bench.execution import supervisor as module
from bench.execution.answers import Box
from bench.execution.supervisor import Supervisor, Task
from bench.execution.trial_process import as_answer
from bench.objective import Trace
from bench.sandbox.process import LostError, RemoteError
from bench.trial import Result, Trial


class Job:
    """Answers as processes would, on a sphere; ``evaluations`` lists the problems whose points were asked for."""

    evaluations: list[list[str]]
    losses: int

    def __init__(self, *arguments, **options):
        pass

    def kill(self):
        pass

    def box(self, problem):
        return Box(("a", "b"), -np.ones(2), np.ones(2), np.zeros(2, bool))

    def prepare(self, trial):
        return None

    def make(self, trial, server):
        x = np.array([0.5, 0.25])
        fun = float((x * x).sum()) - (trial.problem == "cheated")
        trace = Trace(np.array([1]), np.array([fun]))
        return as_answer(Result(x, fun, 7, trace, 0.0, 0.0, 0.0, "done", 0, {}, trial.seed)), 0.0

    def evaluate(self, points, seconds, *, anew=False):
        self.evaluations.append([problem for problem, _ in points])
        if Job.losses:
            Job.losses -= 1
            raise LostError("ended")
        if "broken" in self.evaluations[-1]:
            raise RemoteError("ZeroDivisionError")
        return [{"fun": float(np.square(x).sum()), "spread": 0.0, "metrics": {}} for _, x in points]


@pytest.fixture
def rows(monkeypatch, small_study):
    """Make trials on the problems named; return their statuses by problem."""
    monkeypatch.setattr(module, "Job", Job)
    monkeypatch.setattr(module, "TOGETHER", 1e9)
    Job.evaluations, Job.losses = [], 0

    def make(*problems, losses=0):
        Job.losses = losses
        trials = [Trial(problem, "optimizer", number, 1) for number, problem in enumerate(problems)]
        return {trial.problem: row for trial, row in Supervisor(Task(small_study)).make(trials)}

    return make


def test_the_points_of_many_trials_are_evaluated_together(rows):
    assert [row["status"] for row in rows("a", "b", "c").values()] == ["ok"] * 3
    assert Job.evaluations == [["a", "b", "c"]]


def test_a_trial_that_is_evaluated_wrong_fails_alone(rows):
    found = rows("a", "cheated", "c")
    assert [found[each]["status"] for each in ("a", "cheated", "c")] == ["ok", "failed", "ok"]
    assert "its best point has" in found["cheated"]["error"]
    assert Job.evaluations == [["a", "cheated", "c"], ["cheated"]]


def test_a_point_that_cannot_be_evaluated_fails_alone(rows):
    found = rows("a", "broken", "c")
    assert [found[each]["status"] for each in ("a", "broken", "c")] == ["ok", "failed", "ok"]
    assert "ZeroDivisionError" in found["broken"]["error"]
    assert "evaluated again" in found["broken"]["error"]


def test_an_evaluator_that_is_lost_is_replaced_twice(rows):
    assert rows("a", losses=2)["a"]["status"] == "ok"
    assert rows("a", losses=3)["a"]["status"] == "failed"
