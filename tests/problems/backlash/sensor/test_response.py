"""What the best fits make of disturbances whose peak is known, and the calibration that comes with the package."""

import shlex
from importlib.resources import files

import numpy as np
import pytest

from problems.backlash.commands.calibrate import _gaps
from problems.backlash.joint import Joint
from problems.backlash.sensor import response
from problems.backlash.signature.calibration import calibrate, sensor_calibration
from problems.backlash.signature.datasets import noisy
from problems.backlash.signature.model import A, strength
from problems.backlash.signature.problem import SignatureFit


@pytest.fixture(scope="module")
def shipped():
    return sensor_calibration()


def test_peaks_and_fits_of_the_calibration_that_comes_along_are_those_of_this_code(shipped):
    assert shipped.name == "default joint, simulated, half-gaps 0 … 0.0051 rad"
    rows = [5, 39]
    gaps = shipped.half_gap[rows].tolist()
    np.testing.assert_allclose(calibrate(Joint(), gaps).amplitude, shipped.amplitude[rows], rtol=1e-6)
    made = response.response(Joint(), gaps[1:])
    found, stored = made | made["shown"], vars(shipped) | shipped.shown
    for name, near in {"fitted": 1e-4, "scatter": 1e-2, "ringing": 1e-4, "decay": 1e-3, "ripple": 1e-6}.items():
        np.testing.assert_allclose(found[name], stored[name][rows[1:]], rtol=near)
    scatter = made["scatter"] / made["fitted"]
    assert (scatter > 0.003).all()
    assert (scatter < 0.01).all()


def test_its_first_line_is_the_command_that_makes_it(shipped):
    text = (files("problems.backlash.signature") / "sensor_calibration.toml").read_text(encoding="utf-8")
    program, name, *arguments = shlex.split(text.splitlines()[0].removeprefix("# "))
    assert (program, name) == ("bench", "calibrate")
    assert arguments[0] == "--gaps"
    assert _gaps(arguments[1]) == shipped.half_gap.tolist()
    assert not arguments[2:]


@pytest.mark.parametrize(("level", "draw"), [(3, 0), (18, 0)])
def test_it_takes_off_most_of_what_a_noisy_fit_is_wrong_by(shipped, level, draw):
    recording = noisy(level, "low", draw)
    x = SignatureFit("noisy", recording).reference().x
    found = shipped.expected(60 * strength(x)) / 60
    before, after = (abs(amplitude / recording.peak - 1) for amplitude in (abs(x[A]), found))
    assert before > 0.01
    assert after < 0.6 * before
