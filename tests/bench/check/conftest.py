import json

import pytest

from bench.check.problems import FUNCTIONS


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Some of the faulty optimizers leave files."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def little_work(monkeypatch):
    """Look for biases on one of the functions, in short runs."""
    monkeypatch.setattr("bench.check.runs.FUNCTIONS", {"sphere": FUNCTIONS["sphere"]})
    monkeypatch.setattr("bench.check.runs.FUNCTION_BUDGET", 2_000)


class InThisProcess:
    """Stands in for the processes: makes every call here, and passes its answer on as JSON."""

    def __init__(self, n_jobs, ready, sandbox=None):
        ready()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def answers(self, calls):
        for call in calls:
            yield call, json.loads(json.dumps(call.function(*call.arguments)))


@pytest.fixture
def in_this_process(monkeypatch):
    """Make the runs that show biases without other processes, which take a second to start."""
    monkeypatch.setattr("bench.check.runs.Callers", InThisProcess)
