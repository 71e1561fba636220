import numpy as np
import pytest

from bench.contract.objective import Trace
from bench.execution.answers import Box
from bench.execution.job import Task
from bench.execution.supervisor import Supervisor
from bench.execution.trial_process import as_answer
from bench.sandbox.process import DiedError, LostError, RemoteError, TimeExceededError
from bench.trial.columns import named
from bench.trial.trial import Trial
from tests.bench.made import result


class Job:
    """Answers as processes would, or ends as its problem's name says, as often as ``losses`` says."""

    made: int
    losses: int
    doing = ""

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

    def make(self, trial, server, held):
        Job.made += 1
        if Job.losses:
            Job.losses -= 1
            raise {"lost": LostError("ended"), "killed": DiedError(-9), "crashed": DiedError(-11)}[trial.problem]
        self.doing = "while its best point was evaluated again"
        if trial.problem == "broken":
            raise RemoteError("ZeroDivisionError")
        if trial.problem == "slow":
            raise TimeExceededError("300 s")
        x = np.array([0.5, 0.25])
        fun = float((x * x).sum())
        trace = Trace(np.array([1]), np.array([fun]))
        return as_answer(result(x, fun, trace=trace, nfev=7, stop="done")) | {"metrics": {"radius": 0.5}}


@pytest.fixture
def row(small_study):
    """Make a trial on the problem named; return its row."""
    Job.made = 0

    def make(problem, losses=0):
        Job.losses = losses
        return Supervisor(Task(small_study), Job).make(Trial(problem, "optimizer", 0, 1))

    return make


def test_a_trial_s_row_has_the_metrics_of_its_best_point(row):
    found = row("a")
    assert (found["status"], named(found, "metrics"), Job.made) == ("ok", {"radius": 0.5}, 1)


def test_what_fails_after_the_search_says_so(row):
    assert row("broken")["error"] == "ZeroDivisionError while its best point was evaluated again"
    assert row("slow") == {
        "status": "timeout", "error": "stopped while its best point was evaluated again, after 300 s (--timeout)"
    }  # fmt: skip


@pytest.mark.parametrize("how", ["lost", "killed"])
def test_a_trial_whose_process_is_killed_from_outside_is_begun_once_more(row, how):
    assert row(how, losses=1)["status"] == "ok"
    assert row(how, losses=2)["status"] == "failed"
    assert Job.made == 4


def test_a_crash_is_not_tried_again(row):
    assert "signal SIGSEGV" in row("crashed", losses=1)["error"]
    assert Job.made == 1
