"""GNBG-II against the package iohgnbg."""

import inspect
import textwrap

import numpy as np
import pytest

from bench import Study, load_problem
from problems import studies

iohgnbg = pytest.importorskip("iohgnbg", reason="the extra ioh is not installed")

NUMBERS = range(1, 25)


@pytest.fixture
def theirs(monkeypatch):
    """Return the package's own objects by number.

    Its evaluation stores arrays of one element as numbers, which numpy 2.4 refuses; a slice takes them.
    """
    source = textwrap.dedent(inspect.getsource(iohgnbg.GNBG.fitness))
    assert source.count("f[k] = ") == 1
    space = dict(vars(iohgnbg.gnbg_problem))
    exec(source.replace("f[k] = ", "f[k : k + 1] = "), space)
    made = []

    class Kept(iohgnbg.GNBG):
        fitness = space["fitness"]

        def __init__(self, *arguments):
            super().__init__(*arguments)
            made.append(self)

    monkeypatch.setattr(iohgnbg.gnbg_base, "GNBG", Kept)

    def of(number):
        iohgnbg.get_problem(number)
        return made[-1]

    return of


@pytest.mark.parametrize("number", NUMBERS)
def test_values_box_and_optimum_are_those_of_the_package(number, theirs):
    problem, package = load_problem(f"gnbg-f{number:02d}-d30"), theirs(number)
    x = np.random.default_rng(number).uniform(-100, 100, (6, 30))
    x[4] = package.OptimumPosition[0]
    x[5] = x[4] + 1e-3
    np.testing.assert_array_equal(problem.evaluate(x), package.fitness(x) - package.OptimumValue)
    assert (problem.lower == package.MinCoordinate).all()
    assert (problem.upper == package.MaxCoordinate).all()
    assert problem.evaluate(x[4:5])[0] == problem.optimum == 0
    assert problem.dimension == package.Dimension


def test_the_studies_have_the_rule_of_the_competition(theirs):
    seen = []
    for path in (studies.gnbg_f01_f15, studies.gnbg_f16_f24):
        study = Study.load(path)
        for entry in study.problems:
            package = theirs(int(entry.label[6:8]))
            assert study.budget.evaluations(30) == package.MaxEvals
            assert study.targets == [package.AcceptanceThreshold]
        assert study.trials == 30
        seen += [entry.label for entry in study.problems]
    assert seen == [f"gnbg-f{number:02d}-d30" for number in NUMBERS]
