import json
from concurrent.futures import Future

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
    """Stands in for a pool: makes every call at once, and passes its answer on as JSON."""

    def __init__(self, jobs, ready, sandbox=None):
        ready()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def submit(self, group, function, *arguments, seconds=None, printed=None, memory=None):
        future = Future()
        try:
            future.set_result(json.loads(json.dumps(function(*arguments))))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def in_this_process(monkeypatch):
    """Make the runs that show biases without other processes, which take a second to start."""
    monkeypatch.setattr("bench.execution.safe_runs.Pool", InThisProcess)
