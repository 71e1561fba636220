"""The section on practical equality; optimizers a, b and c find about 5, 6 and 7 on p and q."""

import pytest

from bench import Results
from bench.topics.equivalence import section as equivalence
from bench.topics.findings import Findings

PROBLEMS = ("p", "q", "r", "s", "t", "u")


def section(folder, rope):
    return equivalence.section(Findings(Results(folder), asked_rope=rope))


def test_without_a_rope_there_is_no_section(make, tmp_path):
    assert section(make(tmp_path / "s"), None) is None


def test_what_differs_and_what_is_equal_is_stated(make, tmp_path):
    changes = {"b": {"fun": 5.0}, "c": {"fun": 9.0}}
    found = section(make(tmp_path / "s", problems=PROBLEMS, changes=changes, trials=12), 1.0)
    assert "a and b are equal (0.999)" in found.text[2]
    assert "b is better than c (0.999)" in found.text[2]
    figure, models, counts = found.items
    assert counts.frame.set_index(["first", "second"]).loc[("a", "c"), "separable"] == 6
    assert models.frame["equal"].round().tolist() == [1, 0, 0]
    assert len(figure.data) == 3


@pytest.mark.parametrize(
    ("options", "rope", "said"),
    [
        ({"optimizers": ("a",)}, 1.0, "There is only one optimizer"),
        ({"skip": [("p", "a"), ("q", "b"), ("q", "c"), ("p", "c")]}, 1.0, "No problem has trials of two optimizers"),
        ({}, 1e9, "The rope of 1e+09 is wider than the range of all values on every problem"),
    ],
)
def test_what_shows_nothing_costs_one_sentence(make, tmp_path, options, rope, said):
    found = section(make(tmp_path / "s", **options), rope)
    assert (*found.text, *found.warnings)[0].startswith(said)
    assert not found.items


def test_one_problem_and_few_trials(make, tmp_path):
    found = section(make(tmp_path / "s", problems=("p",), trials=3), "1%")
    assert "Below 6 trials, as in 3 pairs, nothing is shown." in found.text[1]
    assert len(found.items) == 1
