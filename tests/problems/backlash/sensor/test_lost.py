"""Where samples are lost without a gap in time, as from a logger that numbers its rows."""

from dataclasses import replace

import numpy as np
import pytest

from problems.backlash.joint import simulate
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Settings, estimate
from problems.backlash.sensor.lost import lost_samples

PLAIN = Settings(resamples=0)


def recorded(gap, *blocks, added=0.0, noise=0.2):
    """Return a recording of 12 load turns without blocks, which begin at a sample and are so many samples long."""
    speed = simulate(half_gap=gap, duration=4.8).speed + added
    speed = speed + noise * np.random.default_rng(1).uniform(-0.5, 0.5, len(speed))
    lost = [np.arange(first, first + count) for first, count in blocks]
    return Recording(0.0, 0.002, np.delete(speed, np.concatenate([[], *lost]).astype(int)))


@pytest.mark.sampled(1)
@pytest.mark.parametrize("gap", [0.0016, 0.0005, 0.0024])
def test_a_joint_whose_impacts_jump_is_undecided_and_the_times_are_given(gap):
    recording = recorded(gap, (500, 25), (1200, 25), (1600, 25))
    lost = lost_samples(recording, 0.4)
    assert lost.times == pytest.approx([1.0, 2.35, 3.1], abs=0.2)
    found = estimate(recording, PLAIN)
    assert found.verdict == "undecided"
    assert np.isnan(found.backlash_rad)
    assert found.notes[-1] == str(lost)
    assert "tone" not in "".join(found.notes)


def test_the_part_that_it_advises_gives_the_half_gap():
    recording = recorded(0.0016, (600, 30), (2200, 20))
    lost = lost_samples(recording, 0.4)
    begin, end = (round(time / recording.dt) for time in lost.part)
    part = replace(recording, speed=recording.speed[begin:end])
    assert estimate(part, PLAIN).backlash_rad == pytest.approx(0.0016, rel=0.05)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("gap", [0.0016, 0.0003, 0.0035])
def test_a_whole_recording_has_lost_none(gap):
    assert lost_samples(recorded(gap), 0.4) is None
    assert lost_samples(recorded(gap), 0.4 * 1.002) is None  # a period that is not exact makes no jumps


@pytest.mark.sampled(1)
@pytest.mark.parametrize("hz", [22.5, 22.54, 31.0])
def test_a_healthy_joint_stays_healthy_with_a_tone_and_lost_samples(hz):
    tone = 0.5 * np.sin(2 * np.pi * hz * 0.002 * np.arange(2401))
    recording = recorded(0.0, (500, 25), (1200, 25), added=tone)
    assert lost_samples(recording, 0.4) is None
    assert estimate(recording, Settings(gear_ratio=40.0, resamples=0)).verdict == "no backlash"
