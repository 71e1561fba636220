"""The targets that a study may name."""

import math

import pytest

from bench import BenchError
from bench.study.targets import KINDS, checked, percentages, precisions


@pytest.mark.parametrize(
    ("given", "held"),
    [
        *((kind, kind) for kind in KINDS),
        (" precisions ", "precisions"),
        ([1e-3, 10, 1e-3], [10.0, 1e-3]),
        ("1e-3, 10", [10.0, 1e-3]),
        (["1%", "5%"], ["5%", "1%"]),
        ("1 %,05%", ["5%", "1%"]),
        ("0.1%", ["0.1%"]),
    ],
)
def test_what_is_allowed_is_held_from_easy_to_hard(given, held):
    assert checked(given, "the targets") == held
    assert checked(held, "the targets") == held


@pytest.mark.parametrize(
    "given",
    ["", "precision", "1e-3, 5%", "-1", "0", "nan", "1e999", "0%", "-5%", [], [0], [True], [1, "5%"], [[1]], [math.inf],
     3, None, {}, ["5"], [1.0 + i for i in range(1001)]],
)  # fmt: skip
def test_anything_else_is_refused_in_one_sentence(given):
    with pytest.raises(BenchError, match=r"^the targets must be 'precisions', .* or 'tolerance', ") as error:
        checked(given, "the targets")
    assert "\n" not in str(error.value)


def test_lists_are_read_back():
    assert precisions([10.0, 1e-3]) == [10.0, 1e-3]
    assert percentages(["5%", "0.1%"]) == pytest.approx([0.05, 0.001])
    assert precisions(["5%"]) == percentages([1.0]) == precisions("relative") == percentages("precisions") == []
