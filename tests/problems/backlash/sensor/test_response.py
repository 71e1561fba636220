"""What the best fits make of disturbances whose peak is known, and the calibration that comes with the package."""

import shlex
from importlib.resources import files
from types import SimpleNamespace

import numpy as np
import pytest

from problems.backlash.commands.calibrate import _gaps
from problems.backlash.joint import Joint, simulate
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
    for name, near in {"fitted": 1e-4, "scatter": 1e-2, "ringing": 1e-4, "decay": 1e-3, "ripple": 1e-6}.items():
        np.testing.assert_allclose(made[name], getattr(shipped, name)[rows[1:]], rtol=near)
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


def test_the_recordings_of_a_half_gap_differ_in_their_start_and_in_where_their_samples_fall(monkeypatch):
    recordings, joint = [], Joint(omega_ref=600.0)

    def keep(recording, settings, period):
        recordings.append(recording)
        assert period == joint.turn
        x = np.array([-len(recordings) / 60, 0.0, 15.0])
        turn = SimpleNamespace(ripple=0.05, ringing=20.0 + len(recordings))
        return SimpleNamespace(reference=lambda: SimpleNamespace(x=x)), turn, None

    monkeypatch.setattr(response, "to_fit", keep)
    made = response.response(joint, [0.001])
    assert made == {
        "fitted": pytest.approx([4.5]), "scatter": pytest.approx([np.std(np.arange(1, 9))]),
        "ringing": pytest.approx([24.5]), "decay": pytest.approx([15.0]), "ripple": pytest.approx([3.0]),
    }  # fmt: skip
    turn = joint.turn * 500
    assert {len(each.speed) for each in recordings} == {int(12 * turn) + 1}
    for i, each in enumerate(recordings):
        assert (each.start, each.dt) == (0.0, 1 / 500)
        later = (int(turn * i / 8) + i / 8) / 500
        angle = 0.141 + joint.omega_ref / joint.gear_ratio * later
        same = simulate(joint, half_gap=0.001, duration=each.duration, rate=500.0, start_angle=angle)
        np.testing.assert_allclose(each.speed, same.speed, atol=2e-3)
        if i:
            assert np.abs(each.speed - recordings[i - 1].speed).max() > 0.1
