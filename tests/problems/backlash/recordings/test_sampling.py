"""Fast recordings are averaged down to what the signature needs, and give the same backlash."""

import numpy as np
import pytest

from problems.backlash.joint import Joint, simulate
from problems.backlash.recordings import Recording
from problems.backlash.recordings.sampling import averaged_down
from problems.backlash.sensor.estimate import Settings, estimate


def test_a_fast_recording_keeps_its_time_and_what_is_slow_in_it():
    time = 1e-4 * np.arange(100_001)
    slow = 100 + np.sin(2 * np.pi * 25 * time) + time
    made, note = averaged_down(Recording(3.0, 1e-4, slow + np.sin(2 * np.pi * 1990 * time)))
    assert note == "the recording was averaged down from 10000 to 500 Hz"
    assert (made.start, made.dt, made.duration) == (3.0, pytest.approx(0.002), pytest.approx(10.0))
    np.testing.assert_allclose(made.speed[20:-20], slow[::20][20:-20], atol=2e-3)


def test_the_estimate_at_10_khz_is_that_at_500_hz():
    """Agreement to 1%: without noise, the place of the samples alone changes an estimate by so much."""
    run = simulate(Joint(), half_gap=0.002, duration=2.4, rate=10_000.0)
    settings = Settings(gear_ratio=40.0, resamples=0)
    fast = estimate(Recording(0.0, 1e-4, run.speed), settings)
    usual = estimate(Recording(0.0, 0.002, run.speed[::20]), settings)
    assert len(fast.fit.recording.speed) == len(usual.fit.recording.speed)
    assert fast.backlash_rad == pytest.approx(usual.backlash_rad, rel=0.01)
    assert fast.notes[0] == "the recording was averaged down from 10000 to 500 Hz"


def test_a_clipped_peak_is_seen_before_the_average_hides_it():
    from bench import BenchError

    run = simulate(Joint(), half_gap=0.002, duration=2.4, rate=10_000.0)
    with pytest.raises(BenchError, match="the speed is clipped"):
        estimate(Recording(0.0, 1e-4, np.minimum(run.speed, np.quantile(run.speed, 0.98))))
