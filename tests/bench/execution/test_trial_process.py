"""The functions that are called in the processes of a run, called here."""

import pytest

from bench import Study
from bench.execution import trial_process
from bench.helpers.errors import PROBLEM_FAILED
from bench.sandbox.side_effects import reset_random

CODE = """
import bench

class Mine(bench.FunctionProblem):
    def __init__(self):
        super().__init__(lambda x: (x**2).sum(axis=1), [-1.0] * 2, [1.0] * 2)

    def describe(self, x):
        return METRICS
"""


@pytest.fixture
def confirmed(tmp_path):
    """Return a function that makes a trial on a problem with such metrics, and then returns what confirms it."""

    def confirm(metrics):
        (tmp_path / "mine.py").write_text(CODE.replace("METRICS", metrics))
        name = f"{tmp_path}/mine.py:Mine"
        study = {"name": "s", "trials": 1, "budget": 30, "problems": [name], "optimizers": ["random-search"]}
        trial_process.begin(made := Study.from_dict(study), {}, "", {})
        reset_random()  # as a process of its own begins, whatever other tests left
        (trial,) = made.plan()
        assert "error" not in trial_process.make(trial)
        return trial_process.confirm(trial.problem)

    return confirm


def test_the_best_point_is_described_once_its_value_is_confirmed(confirmed):
    assert [*confirmed("{'norm': abs(x).sum()}")["metrics"]] == ["norm"]


@pytest.mark.parametrize("metrics", ["None", "5", "{'norm': 'wide'}", "{'norm': None}"])
def test_metrics_that_are_no_numbers_are_the_problem_s_error(confirmed, metrics):
    assert confirmed(metrics)["error"].startswith(PROBLEM_FAILED)
