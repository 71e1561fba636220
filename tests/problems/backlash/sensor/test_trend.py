"""The trend of a joint: its slope against scipy-free arithmetic, and when the limit is reached."""

import math
from itertools import combinations
from statistics import median

import numpy as np
import pytest

from problems.backlash.joint.wear import half_gaps
from problems.backlash.sensor.recording_files import Series
from problems.backlash.sensor.trend import fit_line, trend

GAPS = np.array([0.0010, 0.0011, 0.0013, 0.0012, 0.0014, 0.0015, 0.0016, 0.0017])


@pytest.fixture(scope="module")
def trend_of(make_estimate):
    def make(gaps, *, limit=0.0021, name="joint4", at=None, **others):
        at = np.arange(len(gaps), dtype=float) if at is None else np.array(at, dtype=float)
        estimates = [make_estimate(float(gap), **others) for gap in gaps]
        return trend(Series(name, tuple(range(len(gaps))), at, "month"), estimates, limit_rad=limit)

    return make


def test_the_slope_is_the_median_of_all_pairs_slopes_and_the_p_value_is_kendalls_exact_one():
    time = np.arange(5.0)
    values = np.array([1.0, 3.0, 2.0, 4.0, 9.0])
    line = fit_line(time, values)
    slopes = [(values[j] - values[i]) / (j - i) for i, j in combinations(range(5), 2)]
    assert line.slope == pytest.approx(median(slopes))
    assert line.p_value == pytest.approx(10 / 120)  # nine of ten pairs rise: 1 + 4 orders of 120 so, either way
    assert line.interval[0] <= line.slope <= line.interval[1]
    assert line.at(np.array([2.0])) == pytest.approx([3.0])  # the medians
    assert line.reaches(6.0) == pytest.approx(2 + 3 / line.slope)
    assert line.reaches(6.0, slope=-1.0) == math.inf


def test_growth_is_significant_and_its_limit_is_foreseen_with_a_range(trend_of):
    made = trend_of(GAPS)
    assert made.significant
    status, when, (early, late) = made.outlook
    assert (status, made.latest) == ("predicted", 6)
    assert 7 < early <= when <= late
    assert when == pytest.approx(11, abs=0.5)  # 4e-4 rad after the last, at 1e-4 rad a month


def test_what_does_not_grow_beyond_chance_has_no_forecast(trend_of):
    for gaps in (GAPS[::-1], np.full(8, 0.001), GAPS[[3, 1, 4, 0, 7, 2, 5, 6]]):
        assert trend_of(gaps).outlook[0] == "no growth"
    assert not trend_of(np.full(8, 0.001)).significant
    assert trend_of(GAPS[::-1]).significant  # it falls


def test_a_limit_that_was_passed_is_passed_since_the_first_recording_that_stays_above(trend_of):
    made = trend_of(GAPS, limit=0.00125)
    assert made.outlook[:2] == ("passed", 4.0)  # 0.0013 in the third did not stay
    assert trend_of(GAPS, limit=0.0001).outlook[:2] == ("passed", 0.0)


def test_the_later_half_foretells_the_limit_of_wear_that_runs_in_fast(trend_of):
    gaps = half_gaps(0.0003, 0.0039, 36)
    true = float(np.interp(0.0021, gaps, np.arange(36)))
    made = trend_of(gaps[:13])
    assert made.latest == 7
    assert abs(made.outlook[1] - true) < 3 < true - made.line.reaches(0.0021)
