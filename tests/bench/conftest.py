import os
import sys
from pathlib import Path

import pytest

from bench import plugins

INSTALLED = Path(__file__).parent / "installed"


@pytest.fixture(scope="session", autouse=True)
def testing_plugins():
    """Put the tests' own plug-in package on the path of this process and of every worker and command it starts."""
    sys.path.append(str(INSTALLED))
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [before, str(INSTALLED)]))
    plugins.entries.cache_clear()
    yield
    sys.path.remove(str(INSTALLED))
    os.environ.pop("PYTHONPATH")
    if before is not None:
        os.environ["PYTHONPATH"] = before
    plugins.entries.cache_clear()


@pytest.fixture
def small_study():
    """Two problems, three optimizers, three trials: fast, and every value is known to depend on its seed."""
    from bench import Study

    return Study.from_dict(
        {
            "name": "small",
            "trials": 3,
            "budget": 60,
            "seed": 5,
            "problems": [{"names": ["sphere-2", "sphere-3"]}],
            "optimizers": [{"name": "hill-climber"}, {"name": "scatter", "agents": 7}, {"name": "early"}],
        }
    )
