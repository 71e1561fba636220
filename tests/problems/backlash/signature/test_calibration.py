"""From amplitudes to backlash: calibrations of any joint, their files and figures."""

from dataclasses import replace

import numpy as np
import pytest

from bench.helpers.errors import BenchError
from problems.backlash.joint import Joint, half_gap
from problems.backlash.signature.calibration import (
    EQUATION_4_7,
    Calibration,
    calibrate,
    default_calibration,
    load_calibration,
    sensor_calibration,
)

LEVELS = [half_gap(level) for level in range(2, 12)]

PAIRS = "amplitude_rpm = [3, 4]\nhalf_gap_rad = [0.1, 0.2]\n"


@pytest.fixture(scope="module")
def made():
    return calibrate(Joint(), LEVELS)


def pairs(amplitude, gaps=None):
    amplitude = np.array(amplitude, dtype=float)
    gaps = 1e-4 * np.arange(len(amplitude)) if gaps is None else np.array(gaps, dtype=float)
    return Calibration(amplitude, gaps)


def test_the_thesis_s_joint_and_levels_give_equation_4_7(made):
    between = np.linspace(*made.range, 501)
    thesis = 1e-6 * np.polyval(EQUATION_4_7, between)
    found, cubic = np.array([made.backlash(a) for a in between]), 1e-6 * np.polyval(made.coefficients, between)
    for curve in (found, cubic):
        np.testing.assert_allclose(curve, thesis, rtol=0.03)
    assert made.deviation == pytest.approx(np.abs(found / thesis - 1).max(), rel=0.01)
    assert 0.02 < made.deviation < 0.03
    identified = 1e-6 * np.polyval([-0.00149, 0.4055, 10.846, 16.63], between)
    np.testing.assert_allclose(cubic, identified, atol=6e-7)


def test_outside_its_range_a_calibration_returns_nan():
    made = pairs([1, 2, 4, 7])
    assert made.range == (1.0, 7.0)
    for amplitude in (1.0, -1.0, 7.0, 3.3):
        assert np.isfinite(made.backlash(amplitude))
    for amplitude in (0.999, 0.0, -7.001, float("inf"), float("nan")):
        assert np.isnan(made.backlash(amplitude))


def test_the_stored_default_calibration_is_that_of_the_simulator():
    gaps = [0.0, *(half_gap(level) for level in range(1, 21)), *(half_gap(20) + 0.0004 * step for step in range(1, 6))]
    made, stored = calibrate(Joint(), gaps), default_calibration()
    assert stored.name == made.name == "default joint, simulated, half-gaps 0 … 0.0059 rad"
    np.testing.assert_array_equal(stored.half_gap, made.half_gap)
    np.testing.assert_allclose(stored.amplitude, made.amplitude, rtol=1e-9)  # the last digits are the machine's
    assert stored.gear_ratio == made.gear_ratio
    assert (stored.speed_rps, stored.friction) == (made.speed_rps, made.friction)


def test_a_fitted_amplitude_gives_the_peak_that_it_was_fitted_to(tmp_path):
    columns = {"fitted": np.array([1.0, 3.0, 4.5, 8.0]), "scatter": np.array([0.1, 0.15, 0.9, 0.8])}
    fitting = replace(pairs([1, 2, 4, 7]), **columns)
    fitting.save(tmp_path / "a.toml", command="bench calibrate --fits")
    assert (tmp_path / "a.toml").read_text().startswith("# bench calibrate --fits\n")
    for made in (fitting, load_calibration(tmp_path / "a.toml")):
        assert (made.fitted[0], made.fitted[-1]) == (1.0, 8.0)
        assert [made.expected(a) for a in (1.0, 3.0, 4.5, 8.0)] == pytest.approx([1, 2, 4, 7])
        between = [made.expected(a) for a in np.linspace(1, 8, 100)]
        assert (np.diff(between) > 0).all()
        assert all(np.isnan(made.expected(a)) for a in (0.99, 8.01, 0.0, float("nan")))
        assert [made.relative_scatter(a) for a in (1, 3, 4.5, 8)] == pytest.approx([0.1, 0.05, 0.2, 0.1])
        assert [made.relative_scatter(a) for a in (2, 0.5, 9)] == pytest.approx([0.075, 0.1, 0.1])
        assert made.backlash(3.0) == pairs([1, 2, 4, 7]).backlash(3.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("amplitude_rpm = [1, 2]", "half_gap_rad must be a list of numbers"),
        ("amplitude_rpm = [1, true]\nhalf_gap_rad = [0, 1]", "amplitude_rpm must be a list of numbers"),
        ("amplitude_rpm = [1, 2]\nhalf_gap_rad = [0, 1, 2]", "2 amplitudes and 3 half-gaps"),
        ("amplitude_rpm = [1, nan]\nhalf_gap_rad = [0, 1]", "every amplitude of a calibration must be finite"),
        ("amplitude_rpm = [2, 1]\nhalf_gap_rad = [0, 1]", "the amplitude does not grow"),
        ("amplitude_rpm = [1, 2]\nhalf_gap_rad = [1, 0]", "the half-gap does not grow"),
        ("amplitude_rpm = [1]\nhalf_gap_rad = [1]", "needs at least 2 pairs"),
        (f"{PAIRS}ringing_hz = [20]", "a finite and positive ringing of each half-gap"),
        ("amplitudes = [1, 2]", "the unknown entry 'amplitudes'; did you mean 'amplitude_rpm'?"),
        (f"{PAIRS}fitted_rpm = [1, 2]", "fitted amplitudes and their scatter come together"),
        (f"{PAIRS}fitted_rpm = [1, 2]\nscatter_rpm = [1, -1]", "every scatter of a calibration must be finite"),
        (f"{PAIRS}fitted_rpm = [0, 2]\nscatter_rpm = [1, 1]", "every fitted amplitude positive"),
        (
            f"{PAIRS}fitted_rpm = [2, 1.5]\nscatter_rpm = [1, 1]",
            "after the half-gap of 0.1 rad the fitted amplitude does not grow but falls by 25%; take half-gaps",
        ),
        (f"{PAIRS}gear_ratio = 0", "the gear_ratio of a calibration must be a positive number, not 0"),
    ],
)
def test_a_file_that_is_not_a_calibration_is_refused_in_one_sentence(tmp_path, text, message):
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(BenchError) as caught:
        load_calibration(tmp_path / "a.toml")
    assert message in str(caught.value)
    assert "a.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_advice_names_half_gaps_whose_amplitudes_no_larger_one_has_again():
    gaps = np.array([0.0, 0.001, 0.002, 0.003, 0.004])
    for amplitude, advice in (
        ([1, 2, 4, 8, 3], "up to 0.001 rad, above which it is never so small again: --gaps 0:0.001:2"),
        ([1, 2, 4, 8, 8], "up to 0.002 rad, above which it is never so small again: --gaps 0:0.002:3"),
        ([1, 2, 3, 4, 0], "take half-gaps over which it grows"),
    ):
        with pytest.raises(BenchError) as caught:
            pairs(amplitude, gaps)
        assert str(caught.value).endswith(advice)


@pytest.mark.parametrize(
    ("name", "alike", "other", "said"),
    [
        ("ringing", 1.015, 0.97, "the impacts ring at 20.8 Hz, the calibration's at 21.5"),
        ("decay", 1.25, 0.65, "they decay by 9.55 a second, the calibration's by 14.7"),
        ("ripple", 0.85, 1.3, "the load's ripple is 4.28 rpm, the calibration's 3.29"),
    ],
)
def test_what_a_recording_shows_of_another_load_or_controller_is_said(name, alike, other, said):
    made = sensor_calibration()
    at = float(made.fitted[11])
    own = {each: float(made.shown[each][11]) for each in ("ringing", "decay", "ripple")}
    assert made.other_joint(at, 0.0, own) == ""
    assert made.other_joint(at, 0.0, own | {name: alike * own[name]}) == ""
    assert made.other_joint(at, 0.0, own | {name: other * own[name]}).startswith(f"{said}; calibrate this joint")
    assert made.other_joint(at, 0.0, own | {name: other * own[name]}, wider=2.0) == ""
    assert made.other_joint(at, 0.0, own | {name: np.nan}) == ""
    assert replace(made, shown={}).other_joint(at, 0.0, own | {name: other * own[name]}) == ""
