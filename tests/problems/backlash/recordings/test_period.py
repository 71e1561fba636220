"""The time of one load turn, found in a signal or by the gear ratio."""

from math import pi

import numpy as np
import pytest

from problems.backlash.joint import half_gap, load_joint, simulate
from problems.backlash.recordings import Recording, read
from problems.backlash.recordings.period import find_period, period_from_gear
from problems.backlash.signature.datasets import dataset

SAMPLE = 0.002


def noisy(level, speed, seed, times=1.0):
    """The speed with the noise of section 7.2.2 at this level, which is 1.5 times as much where it is high."""
    span = times * (0.2 + 0.3 * (level - 1) / 19)
    return Recording(0.0, SAMPLE, speed + span * np.random.default_rng(seed).uniform(-0.5, 0.5, len(speed)))


@pytest.mark.parametrize("level", range(2, 21))
@pytest.mark.parametrize("times", [0.0, 1.0, 1.5])
def test_the_period_of_every_dataset_is_found_to_a_twelfth_of_a_sample(level, times):
    """So that the last of twelve turns is off by less than a sample."""
    assert find_period(noisy(level, dataset(level).speed, level, times)) == pytest.approx(0.4, abs=SAMPLE / 12)


@pytest.mark.parametrize("speed", [60.0, 40 / 0.408, 127.0])
@pytest.mark.parametrize("level", [2, 12])
def test_a_period_of_no_whole_number_of_samples_is_found(speed, level):
    joint = load_joint(omega_ref=2 * pi * speed)
    made = noisy(level, simulate(joint, half_gap=half_gap(level)).speed, 1)
    assert find_period(made) == pytest.approx(joint.turn, abs=SAMPLE / 12)
    assert period_from_gear(made, 40.0) == pytest.approx(joint.turn, abs=SAMPLE / 24)


def test_the_period_is_made_whole_only_where_that_is_within_its_uncertainty():
    assert find_period(Recording(0.0, SAMPLE, dataset(12).speed)) == 0.4
    joint = load_joint(omega_ref=2 * pi * 60)
    between = find_period(Recording(0.0, SAMPLE, simulate(joint, half_gap=half_gap(12)).speed))
    assert between == pytest.approx(2 / 3, abs=1e-5)
    assert abs(between / (2 * SAMPLE) % 1 - 2 / 3) < 0.01


def test_no_period_is_claimed_of_noise():
    rng = np.random.default_rng(0)
    for _ in range(20):
        white = 0.1 * rng.standard_normal(2401)
        slow = np.cumsum(0.01 * rng.standard_normal(2401))
        for noise in (white, slow):
            assert find_period(Recording(0.0, SAMPLE, 100 + noise)) is None


def test_a_signal_without_antiperiodicity_has_no_period():
    """A pulse of one sign a turn has even harmonics as well."""
    pulse = np.exp(-0.5 * ((np.arange(2400) % 200 - 100) / 5) ** 2)
    assert find_period(Recording(0.0, SAMPLE, 100 + pulse)) is None
    turned = pulse * (-1.0) ** (np.arange(2400) // 200)
    assert find_period(Recording(0.0, SAMPLE, 100 + turned)) == pytest.approx(0.8, abs=1e-4)


def test_the_published_recordings_have_the_notebook_s_period(published):
    for level in (3, 12):
        assert find_period(read(published / f"Speeddata{level}.xlsx")) == 0.4
