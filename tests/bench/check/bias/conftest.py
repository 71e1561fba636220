import pytest

from bench.check.bias.functions import FUNCTIONS


@pytest.fixture
def little_work(monkeypatch):
    """Leave one of the functions, and short runs on it; a worker process of this test's would not know of it."""
    monkeypatch.setattr("bench.check.bias.runs.FUNCTIONS", {"sphere": FUNCTIONS["sphere"]})
    monkeypatch.setattr("bench.check.bias.runs.FUNCTION_BUDGET", 2_000)
