import math

import numpy as np
import pytest

from bench import BenchError
from bench.numbers import is_finite, require_positive, require_whole


@pytest.mark.parametrize("value", [0, 5, np.int64(3)])
def test_whole_numbers_within_the_range_pass(value):
    require_whole("n", value, 0, 5)


@pytest.mark.parametrize("value", [-1, 6, 1.0, "1", None, True, math.nan])
def test_any_other_value_is_one_sentence(value):
    with pytest.raises(BenchError) as raised:
        require_whole("n", value, 0, 5, also=", or all")
    assert str(raised.value) == f"n must be a whole number from 0 to 5, or all, not {value!r}"


def test_without_limits_every_whole_number_passes():
    require_whole("n", -(10**30))
    with pytest.raises(BenchError, match=r"^n must be a whole number, not 0.5$"):
        require_whole("n", 0.5)


@pytest.mark.parametrize("value", [1, 0.5, np.float64(2.0), 10])
def test_positive_numbers_up_to_the_limit_pass(value):
    require_positive("t", value, 10)


@pytest.mark.parametrize("value", [0, -1, 11, math.inf, math.nan, True, "1", None])
def test_what_is_not_positive_is_one_sentence(value):
    with pytest.raises(BenchError) as raised:
        require_positive("t", value, 10, unit="seconds")
    assert str(raised.value) == f"t must be a positive number of seconds of at most 10, not {value!r}"


def test_neither_truth_nor_infinity_is_a_finite_number():
    none = True, math.inf, -math.inf, math.nan, 10**400, "1", 1j
    assert [is_finite(each) for each in (1, 1.5, *none)] == [True, True, *[False] * len(none)]
