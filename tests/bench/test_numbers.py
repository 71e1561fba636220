import math

import numpy as np
import pytest

from bench import BenchError
from bench.numbers import (
    LARGEST_SEED,
    is_finite,
    require_jobs,
    require_positive,
    require_seed,
    require_whole,
    seconds,
)


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


def test_seeds_are_what_a_store_can_hold():
    for seed in (0, LARGEST_SEED):
        require_seed("the seed", seed)
    for seed in (-1, LARGEST_SEED + 1, 0.0):
        with pytest.raises(BenchError, match=r"^the seed must be a whole number from 0 to 9223372036854775807, not "):
            require_seed("the seed", seed)


def test_jobs_are_as_many_as_a_machine_can_have_or_one_for_every_core():
    for jobs in (-1, 1, 1000):
        require_jobs("--jobs", jobs)
    for jobs in (0, -2, 1001, 99_999_999, None):
        with pytest.raises(BenchError, match=r"^--jobs must be a whole number from 1 to 1000, or -1 for every core, "):
            require_jobs("--jobs", jobs)


@pytest.mark.parametrize(
    ("value", "expected"), [(30, 30), ("30", 30), ("0.5 s", 0.5), ("10 min", 600), ("2h", 7200), ("1 d", 86400)]
)
def test_a_duration_has_a_unit_or_is_in_seconds(value, expected):
    assert seconds(value, "time") == expected


@pytest.mark.parametrize("value", [0, -1, "soon", "1 year", "1.2.3 s", True, float("inf"), None, "0 s"])
def test_any_other_duration_is_one_sentence(value):
    with pytest.raises(BenchError, match="time must be a number of seconds above 0, or a text such as '10 min', not"):
        seconds(value, "time")
