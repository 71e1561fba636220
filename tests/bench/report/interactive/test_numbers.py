"""What the interactive part computes and writes, without a browser."""

import math

import numpy as np
import pytest


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (1234567, "1,234,567"),
        (1e9, "1.000e+9"),
        (0.5, "0.5"),
        (1234.56789, "1234.57"),
        (0.00012345, "1.234e-4"),
        (-2e7 - 0.5, "-2.000e+7"),
    ],
)
def test_a_number_is_short_enough_for_a_cell(value, text, call):
    assert call("text", value) == text


def test_a_share_keeps_three_digits(call):
    assert [call("percent", share) for share in (0, 0.12345, 1)] == ["0%", "12.3%", "100%"]


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_quartiles_are_those_of_numpy(share, call):
    values = np.sort(np.random.default_rng(3).standard_normal(7)).tolist()
    assert call("quartile", values, share) == pytest.approx(np.quantile(values, share))


def test_the_nearest_budget_is_nearest_by_ratio(call):
    assert call("nearest", [1, 10, 100], 30) == 1
    assert call("nearest", [1, 10, 100], 40) == 2


def test_a_column_may_hold_one_value_for_all_runs(call):
    assert (call("one", [5, 6], 1), call("one", 7, 1)) == (6, 7)


class TestScales:
    PADDED = "(values) => padded(scaleOf(values, null, null))"

    def test_wide_positive_values_get_a_log_axis_unless_the_reader_wants_none(self, call):
        values = [1, 10, 1000]
        assert call("scaleOf", values, None, None)["log"]
        assert not call("scaleOf", values, False, None)["log"]
        assert not call("scaleOf", [1, 2, 3], None, None)["log"]

    def test_a_zero_stands_at_the_low_end_of_a_log_axis(self, call):
        scale = call("scaleOf", [0, 3, 900], None, None)
        assert (scale["floor"], scale["domain"]) == (1, [1, 900])

    def test_a_log_axis_of_negative_values_is_refused(self, call):
        scale = call("scaleOf", [-1, 3, 900], True, None)
        assert (scale["log"], scale["refused"]) == (False, True)

    def test_equal_values_and_none_have_an_axis_with_a_width(self, call):
        assert call("scaleOf", [2, 2], None, None)["domain"] == [1.5, 2.5]
        assert call("scaleOf", [], None, None)["domain"] == [0, 1]

    def test_a_margin_leaves_no_point_on_an_edge_and_a_zoomed_axis_as_it_is(self, call):
        assert call(self.PADDED, [1, 3])["domain"] == pytest.approx([0.94, 3.06])
        log = call(self.PADDED, [1, 1000])["domain"]
        assert [math.log10(each) for each in log] == pytest.approx([-0.09, 3.09])
