"""The families of the CEC competitions against minionpy and the organisers' own code."""

import json

import minionpy
import numpy as np
import pytest
from scipy.linalg import invhilbert

from bench import load_problem
from bench.plugins import registry
from tests.problems.suites import best_found

YEARS = (2011, 2014, 2017, 2019, 2020, 2022)


def grid(year):
    return registry.load("problems", f"cec{year}").grid


@pytest.mark.parametrize("name", [name for year in YEARS for name in grid(year).names() if "d100" not in name])
def test_values_are_those_of_minionpy_bit_for_bit(name):
    suite, function, dimension = name.split("-")
    theirs = getattr(minionpy, f"CEC{suite[3:]}Functions")(int(function[1:]), int(dimension[1:]))
    problem = load_problem(name)
    assert list(zip(problem.lower, problem.upper, strict=True)) == theirs.get_bounds()
    x = np.random.default_rng(1).uniform(problem.lower, problem.upper, (4, problem.dimension))
    np.testing.assert_array_equal(problem.evaluate(x), theirs(x.tolist()))


@pytest.mark.parametrize("key", ["cec2017-d10", "cec2017-d30", "cec2017-d50", "cec2022-d10", "cec2022-d20"])
def test_values_are_those_of_the_organisers_code(key, published):
    file = published / "cec-values.json"
    if not file.exists():
        pytest.skip(f"no values of the organisers' code at {file}")
    fixture = json.loads(file.read_text())[key]
    suite, dimension = key.split("-")
    tested = 0
    for number, values in fixture["values"].items():
        if (suite, number) == ("cec2017", "2"):  # withdrawn
            continue
        problem = load_problem(f"{suite}-f{int(number):02d}-{dimension}")
        np.testing.assert_allclose(problem.evaluate(np.array(fixture["points"])), values, rtol=1e-9)
        tested += 1
    assert tested == {"cec2017": 29, "cec2022": 12}[suite]


SHIFTED = [
    (year, name)
    for year in (2014, 2017, 2019, 2020, 2022)
    for name in grid(year).names()
    if not (year == 2017 and "f09" in name)  # Levy's function has its optimum beside the shift
    and not (year == 2019 and grid(year).member(name).function in ("f01", "f02", "f03"))  # these are not shifted
]


@pytest.mark.parametrize(("year", "name"), SHIFTED)
def test_the_optimum_is_the_value_at_the_organisers_shift(year, name):
    problem = load_problem(name)
    value = problem.evaluate(problem.optimum_point[None])[0]
    assert problem.optimum <= value <= problem.optimum + 1e-6


SMALL = [
    name
    for year in YEARS[1:]
    for name in grid(year).names()
    if grid(year).member(name).dimension in (9, 10, 16, 18)
]  # fmt: skip


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", SMALL)
def test_no_search_beats_the_optimum(name):
    problem = load_problem(name)
    start = None if problem.optimum_point is None else problem.optimum_point + 1e-3
    assert best_found(problem, start, points=10_000) >= problem.optimum - 1e-12 * problem.optimum


def test_the_problems_of_2019_that_are_not_shifted_have_their_optimum_at_known_points():
    chebyshev = [[128.0, 0, -256, 0, 160, 0, -32, 0, 1]]  # T8, Storn's problem
    assert load_problem("cec2019-f01-d9").evaluate(np.array(chebyshev)) == load_problem("cec2019-f01-d9").optimum
    inverse = invhilbert(4).reshape(1, -1)
    hilbert = load_problem("cec2019-f02-d16")
    assert 0 <= hilbert.evaluate(inverse)[0] - hilbert.optimum < 1e-9
    atoms = load_problem("cec2019-f03-d18")
    edge = ((12 + 3 / 64) / (12 + 3 / 8)) ** (1 / 6)  # of the octahedron, where its energy is lowest
    octahedron = edge / np.sqrt(2) * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    assert atoms.evaluate(octahedron.reshape(1, -1))[0] == pytest.approx(atoms.optimum, abs=1e-14)
    assert 0 < 1 - atoms.optimum < 1e-11  # by the report it is 1
    assert best_found(atoms, octahedron.ravel() + 1e-3, points=10_000) >= atoms.optimum - 1e-12
