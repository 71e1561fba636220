from collections.abc import Callable
from functools import cache

import pytest

from problems.backlash.joint import Simulation, half_gap, simulate


@pytest.fixture(scope="session")
def simulated() -> Callable[[int], Simulation]:
    """The default simulation of a backlash level, computed once a session."""
    return cache(lambda level: simulate(half_gap=half_gap(level)))
