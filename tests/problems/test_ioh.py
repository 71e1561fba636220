"""sbox-cost, ma-bbob and star-discrepancy against the package ioh."""

import numpy as np
import pytest

from bench import load_problem
from problems.ioh import DISCREPANCIES
from tests.problems.suites import best_found

ioh = pytest.importorskip("ioh", reason="the extra ioh is not installed")

BOXED = [(f"sbox-cost-f{n:02d}-d{d}-i{i}", n, d, i) for n in range(1, 25) for d, i in ((2, 1), (5, 15), (40, 200))]
AFFINE = [(f"ma-bbob-f{n:04d}-d{d}", n, d) for n, d in ((1, 2), (2, 5), (17, 10), (500, 3), (1000, 40))]
STARS = [(f"star-discrepancy-{label}-d{d}-i{d}", n, d) for label, n in DISCREPANCIES.items() for d in (2, 10)]


def points(problem):
    return np.random.default_rng(1).uniform(problem.lower, problem.upper, (12, problem.dimension))


@pytest.mark.parametrize(("name", "number", "dimension", "instance"), BOXED)
def test_values_and_optimum_of_sbox_cost_are_those_of_ioh(name, number, dimension, instance):
    problem = load_problem(name)
    theirs = ioh.get_problem(number, instance, dimension, ioh.ProblemClass.SBOX)
    x = points(problem)
    np.testing.assert_array_equal(problem.evaluate(x), [theirs(row) for row in x])
    assert problem.evaluate(np.full((1, dimension), 5.01)).tolist() == [np.inf]
    best = np.array([theirs.optimum.x])
    assert (problem.repair(best) == best).all()
    assert problem.optimum <= problem.evaluate(best)[0] <= problem.optimum + 1e-12 * abs(problem.optimum)


@pytest.mark.parametrize(("name", "number", "dimension"), AFFINE)
def test_values_and_optimum_of_ma_bbob_are_those_of_ioh(name, number, dimension):
    problem, theirs = load_problem(name), ioh.problem.ManyAffine(number, dimension)
    x = points(problem)
    np.testing.assert_array_equal(problem.evaluate(x), [theirs(row) for row in x])
    assert problem.evaluate(np.array([theirs.optimum.x])).tolist() == [problem.optimum]
    assert 0 < problem.optimum < 1e-9


@pytest.mark.parametrize(("name", "number", "dimension"), STARS)
def test_star_discrepancies_are_those_of_ioh_with_the_other_sign(name, number, dimension):
    problem = load_problem(name)
    theirs = ioh.get_problem(number, dimension, dimension, ioh.ProblemClass.STAR_REAL)
    assert theirs.meta_data.optimization_type == ioh.OptimizationType.MAX
    kind, n = name.split("-")[2:4]
    assert theirs.meta_data.name == f"{kind.capitalize()}StarDiscrepancy{n}"
    x = points(problem)
    np.testing.assert_array_equal(problem.evaluate(x), [-theirs(row) for row in x])
    assert problem.evaluate(np.full((1, dimension), 1.01)).tolist() == [np.inf]
    assert problem.optimum is None


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sbox-cost-f21-d3-i2", 19.769241366593942),
        ("ma-bbob-f0017-d5", 3.0544934537872908),
        ("star-discrepancy-sobol-50-d5-i3", -0.018200000000000004),
    ],
)
def test_every_version_of_ioh_that_is_allowed_has_the_values_of_0_3_22(name, value):
    problem = load_problem(name)
    x = problem.lower + (problem.upper - problem.lower) * np.linspace(0.2, 0.8, problem.dimension)
    assert problem.evaluate(x[None])[0] == pytest.approx(value, rel=1e-13)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", [f"sbox-cost-f{n:02d}-d5-i3" for n in range(1, 25)] + [each[0] for each in AFFINE[:4]])
def test_no_search_beats_the_optimum(name):
    problem = load_problem(name)
    if name.startswith("sbox"):
        theirs = ioh.get_problem(int(name[11:13]), 3, 5, ioh.ProblemClass.SBOX)
    else:
        theirs = ioh.problem.ManyAffine(int(name[9:13]), problem.dimension)
    found = best_found(problem, start=np.array(theirs.optimum.x) + 1e-3, points=2_000)
    assert found >= problem.optimum - 1e-12 * abs(problem.optimum)
