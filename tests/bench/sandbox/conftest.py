"""Processes for the tests of what they do."""

from importlib import import_module

import pytest

from bench.sandbox.process import Process


@pytest.fixture(scope="module")
def calls(testing_plugins):
    """What the processes are asked for: a module that they find too."""
    return import_module("testing_calls")


@pytest.fixture(scope="module")
def started():
    """The processes started for ``shared``, the last one of which is in use."""
    processes = []
    yield processes
    for each in processes:
        each.close()


@pytest.fixture
def shared(started):
    """For calls that leave their process as it was; after an error there is a new one."""
    if not started or started[-1].closed:
        started.append(Process(hash_seed=0))
    return started[-1]


@pytest.fixture
def process():
    """For calls that end it."""
    with Process(hash_seed=0) as process:
        yield process
