"""Processes for the tests of what they do."""

from importlib import import_module

import pytest

from bench.sandbox.process import (
    Process,
)


@pytest.fixture(scope="module")
def calls(testing_plugins):
    """What the processes are asked for: a module that they find too."""
    return import_module("testing_calls")


@pytest.fixture(scope="module")
def shared():
    """For calls that leave their process as it was."""
    with Process(hash_seed=0) as process:
        yield process


@pytest.fixture
def process():
    """For calls that end it."""
    with Process(hash_seed=0) as process:
        yield process
