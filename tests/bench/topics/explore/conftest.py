"""A study with names that could break a page, one failed trial, and data that its points are fitted to."""

import numpy as np
import pytest

from bench import FittedData, FunctionProblem, Results
from bench.topics.findings import Findings

HOSTILE = "q</script><!--'\"&"


class Line(FunctionProblem):
    """A slope through noisy points, whose data a report can show."""

    def __init__(self):
        super().__init__(lambda x: x[:, 0] ** 2, [0.0], [1.0])

    def fitted_data(self):
        t = np.linspace(0.0, 1.0, 50)
        return FittedData(t, 0.5 * t, "point.x1 * datum.t", "time (s)", "height (m)")


@pytest.fixture(scope="module")
def study(make, tmp_path_factory):
    """Return the folder of a study of 2 problems, 3 optimizers and 4 trials, of which one failed."""
    folder = tmp_path_factory.mktemp("further") / "s"
    return make(folder, ("p", HOSTILE), ("a", "b", "<i>c"), trials=4, fail=[("p", "b", 1)])


@pytest.fixture(scope="module")
def findings(study):
    """Return the findings of this study, whose problem p is a line fitted to points."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(Results, "problem", lambda self, label: Line())
        yield Findings(Results(study))


@pytest.fixture(scope="session")
def hostile():
    """Return the label of a problem that could break a page."""
    return HOSTILE
