"""Suites against suites: the verdict on two samples of a function, and comparisons of whole suites by files."""

import numpy as np
import pytest

from bench import BenchError, Grid
from bench.check.suite_pages import cells, summary, versions, write
from bench.check.suites import POINTS, Sample, by_function, compare, compare_suites, sampled
from bench.families import Member
from problems.classical.family import classical

BOX = np.array([[-5.0, -5.0, -5.0], [5.0, 5.0, 5.0]])
HOME = np.array([1.0, 2.0, 3.0])


def sample(values, box=BOX, best=HOME, optimum=0.0):
    """Return what an implementation with these values would return, at the points that a comparison would take."""
    rng = np.random.default_rng(0)
    shares, offsets = rng.random((POINTS, 3)), rng.standard_normal((POINTS, 3))
    at = {"raw": BOX[0] + shares * 10, "shares": box[0] + shares * (box[1] - box[0]), "about": best + offsets}
    return Sample(box, optimum, best, **{name: values(x) for name, x in at.items()})


def bowl(x):
    return ((x - HOME) ** 2 * [1, 10, 100]).sum(axis=1) + np.cos(x[:, 0])


def around(best):
    return lambda x: ((x - best) ** 2 * [1, 10, 100]).sum(axis=1)


@pytest.mark.parametrize(
    ("other", "verdict", "detail"),
    [
        (sample(bowl), "bits", ""),
        (sample(lambda x: bowl(x) * (1 + 1e-15)), "rounding", "relative differences of up to"),
        (sample(lambda x: bowl(x) + 100), "transformed", "its value is the suite's +100"),
        (sample(lambda x: -bowl(x)), "transformed", "its value is -1 times the suite's"),
        (sample(lambda x: 3 * bowl(x) - 7), "transformed", "its value is 3 times the suite's -7"),
        (sample(lambda x: np.sqrt(bowl(x) + 2)), "transformed", "its values have the same order"),
        (sample(lambda x: bowl(x[:, ::-1])), "different", "64 of 64 values differ"),
        (sample(lambda x: np.where(x[:, 0] > 4, 9, bowl(x))), "different", "9 of 64 values differ"),
        (sample(lambda x: np.full(len(x), np.nan)), "different", "64 of 64 values differ"),
        (sample(lambda x: bowl(x / 20), 20 * BOX), "transformed", "equal at the same shares of another box"),
    ],
)
def test_two_samples_are_equal_transformed_or_different(other, verdict, detail):
    found, words = compare(sample(bowl), other)
    assert found == verdict
    assert detail in words


def test_a_function_that_is_only_moved_is_equal_about_its_own_optimum():
    elsewhere = np.array([-2.0, 0.0, 1.0])
    found, words = compare(sample(around(HOME)), sample(around(elsewhere), best=elsewhere))
    assert (found, words) == ("transformed", "equal about its own optimum, which lies elsewhere")


def test_a_difference_is_located_at_the_optimum_and_the_claims_are_named():
    other = sample(lambda x: bowl(x[:, ::-1]), box=2 * BOX, optimum=5.0)
    _, words = compare(sample(bowl), other)
    assert "in place of" in words
    assert "claims the optimum 5, not 0" in words
    assert words.endswith("another box")


CODE = r"""
import sys
import numpy as np
import bench

def own(name, scale=1.0):
    made = bench.load_problem(name)
    return bench.FunctionProblem(lambda x: scale * made.evaluate(x), made.lower, made.upper, optimum=made.optimum)

def same(function, dimension, instance):
    return own(f"classical-{function}-d{dimension}-i{instance}")

def swapped(function, dimension, instance):
    names = {"ellipsoid": "cigar", "cigar": "ellipsoid"}
    if function == "ackley":
        return own(f"classical-{function}-d{dimension}-i{instance}", 2.0)
    return own(f"classical-{names.get(function, function)}-d{dimension}-i{instance}")

def partly(function, dimension, instance):
    if function == "ellipsoid":
        raise ValueError("no ellipsoid\nhere")
    if function == "cigar":
        sys.exit(4)
    if function == "ackley":
        return bench.FunctionProblem(lambda x: x[:, 0], [0] * 3, [1] * 3)
    return "no problem"
"""


@pytest.fixture
def adapters(tmp_path, monkeypatch):
    """A file with three implementations of four functions of the classical suite, in the working folder."""
    (tmp_path / "other.py").write_text(CODE)
    monkeypatch.chdir(tmp_path)
    few = {name: classical.grid.functions[name] for name in ("ellipsoid", "cigar", "ackley", "levy")}
    monkeypatch.setattr("bench.check.suites._grid", lambda suite: Grid("classical", few, 2))


@pytest.mark.slow
def test_a_suite_is_compared_function_by_function_and_a_failure_costs_its_row_alone(adapters, tmp_path):
    others = ["other.py:same", "other.py:swapped", "other.py:partly"]
    made = compare_suites("classical", others, dimensions=[2], jobs=2)
    assert len(made) == 3 * 4 * 2  # instances
    worst = {(each.other[9:], each.member.function): each for each in by_function(made)}
    assert {each.verdict for (other, _), each in worst.items() if other == "same"} == {"bits"}
    assert worst["swapped", "ellipsoid"].detail == "it has the values of its cigar"
    assert worst["swapped", "ackley"].detail == "its value is 2 times the suite's"
    assert worst["swapped", "levy"].verdict == "bits"
    assert {each.verdict for (other, _), each in worst.items() if other == "partly"} == {"missing"}
    assert worst["partly", "ellipsoid"].detail.endswith("ValueError: no ellipsoid here")
    assert "3 variables in place of 2" in worst["partly", "ackley"].detail
    assert summary(made, "classical") == [
        "same, of 4 functions of classical: 4 equal",
        "swapped, of 4 functions of classical: 1 equal (levy), 3 equal up to a transformation",
        "partly, of 4 functions of classical: 4 missing",
    ]
    assert versions(made, "classical")[0] == "ellipsoid: A classical and same; B swapped"
    head, rows = cells(made)
    assert head == ["function", "same", "swapped", "partly"]
    assert rows[2] == ["ackley", "equal", "transformed (B)", "–"]
    page = write(made, "classical", tmp_path / "pages").read_text()
    assert "| ackley | equal | transformed (B) | – |" in page
    assert (tmp_path / "pages" / "classical.csv").read_text().count("\n") == 25


def test_coco_s_boxed_suite_has_the_values_of_sbox_cost_and_not_of_bbob(monkeypatch):
    monkeypatch.setattr("bench.check.suites._grid", lambda suite: Grid(suite, {"f01": (2,), "f05": (2,)}, 2))
    made = by_function(compare_suites("bbob-boxed", ["bbob", "sbox-cost"], jobs=2))
    assert [each.verdict for each in made] == ["different", "bits", "bits", "bits"]


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: compare_suites("nothing", ["bbob"]), "'nothing' is no suite"),
        (lambda: compare_suites("bbob", ["engineering"]), "'engineering' is no suite"),
        (lambda: compare_suites("cec2022", ["cec2017"], dimensions=[7]), "cec2022 has no dimension 7; it has 10, 20"),
    ],
)
def test_what_cannot_be_compared_is_one_sentence(call, sentence):
    with pytest.raises(BenchError, match=sentence):
        call()


def test_a_suite_without_the_dimension_or_the_function_of_the_other_is_missing_there():
    with pytest.raises(BenchError, match="f05 of cec2022 has no dimension 5"):
        sampled("cec2022", Member("f05", 5, 0), None, 0, {})
