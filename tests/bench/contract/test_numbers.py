import math

import pytest

from bench import BenchError
from bench.contract.numbers import is_finite, require_positive, require_whole, seconds


@pytest.mark.parametrize("value", [-1, 6, 1.0, "1", None, True, math.nan])
def test_any_other_value_is_one_sentence(value):
    with pytest.raises(BenchError) as raised:
        require_whole("n", value, 0, 5, also=", or all")
    assert str(raised.value) == f"n must be a whole number from 0 to 5, or all, not {value!r}"


@pytest.mark.parametrize("value", [0, -1, 11, math.inf, math.nan, True, "1", None])
def test_what_is_not_positive_is_one_sentence(value):
    with pytest.raises(BenchError) as raised:
        require_positive("t", value, 10, unit="seconds")
    assert str(raised.value) == f"t must be a positive number of seconds of at most 10, not {value!r}"


def test_neither_truth_nor_infinity_is_a_finite_number():
    none = True, math.inf, -math.inf, math.nan, 10**400, "1", 1j
    assert [is_finite(each) for each in (1, 1.5, *none)] == [True, True, *[False] * len(none)]


@pytest.mark.parametrize(
    ("value", "expected"), [(30, 30), ("30", 30), ("0.5 s", 0.5), ("10 min", 600), ("2h", 7200), ("1 d", 86400)]
)
def test_a_duration_has_a_unit_or_is_in_seconds(value, expected):
    assert seconds(value, "time") == expected
