import numpy as np
import pytest

from bench.report.interactive.coding import coded, packed, short, signal


def test_a_curve_keeps_its_values_to_a_thousandth(decoded):
    rng = np.random.default_rng(1)
    curves = np.sort(10.0 ** rng.uniform(-12, 9, (20, 60)), axis=1)[:, ::-1]
    texts = coded(curves)
    assert np.allclose([decoded(text, 60) for text in texts], curves, rtol=1.2e-3, atol=0)


@pytest.mark.parametrize(
    ("curve", "text"),
    [
        ([np.inf, np.inf, 100.0, 100.0, 10.0, 0.0, 0.0], "i,,2000,,1000,z"),
        ([1.0, 1.0, 1.0], "0"),
        ([np.inf] * 3, "i"),
        ([0.0] * 3, "z"),
    ],
)
def test_what_does_not_change_takes_no_character(curve, text, decoded):
    assert coded(np.array([curve])) == [text]
    assert decoded(text, len(curve)).tolist() == curve


def test_a_signal_keeps_its_values_to_a_part_in_ten_thousand_of_its_range():
    values = np.cumsum(np.random.default_rng(2).standard_normal(500))
    made = signal(values)
    levels = np.cumsum([int(step or 0) for step in made["steps"].split(",")])
    assert np.allclose(
        made["low"] + levels / 9999 * (made["high"] - made["low"]), values, rtol=0, atol=np.ptp(values) / 19_000
    )
    assert signal([3.0, 3.0]) == {"low": 3, "high": 3, "steps": ","}


def test_numbers_are_short_and_lists_of_one_value_are_that_value():
    assert [short(each) for each in (1234.56789, 2.0, np.inf, np.nan, None, 1e300)] == [
        1234.568, 2, None, None, None, 1e300,
    ]  # fmt: skip
    assert (packed([5, 5]), packed([5, 6]), packed([5]), packed([])) == (5, [5, 6], [5], [])
