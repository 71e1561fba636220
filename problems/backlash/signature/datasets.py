"""Simulate recordings, such as the twenty of section 7.2.1 and, with noise, those of section 7.3."""

from dataclasses import replace
from functools import cache

import numpy as np

from bench.contract.numbers import require_whole
from bench.helpers.errors import BenchError
from problems.backlash import LEVELS
from problems.backlash.joint import DEFAULT, Joint, half_gap, simulate, with_noise
from problems.backlash.recordings import Recording

RATE = 500.0  # Hz
NOISES = ("low", "high")  # the levels of noise of section 7.3
FIRST_SAMPLES = 100  # the number of first samples at which a noisy recording may start (section 7.3)


@cache
def dataset(level: int) -> Recording:
    """Return the recording of a level 1 … 20; raises BenchError outside."""
    return simulated(half_gap(level))


def peak_to_peak(level: int, noise: str = "low") -> float:
    """Return the peak-to-peak value in rps of the noise on a dataset 1 … 20; 0 has the noise of dataset 1.

    Eq. 7.2 with the range of the authors' published recordings: 0.2 to 0.5 rps, and 1.5 times that at the high level.
    Table 7.3 lists half of the peak-to-peak value.
    """
    return (0.2 + 0.3 * (max(level, 1) - 1) / 19) * (1.5 if noise == "high" else 1.0)


def noisy(level: int, noise: str = "low", draw: int = 0) -> Recording:
    """Return a dataset with uniform white noise (eqs. 7.1 and 7.2), cut at a random one of its first 100 samples.

    It begins at 0 s. Without backlash its peak is 0 and its half-gap None.

    Args:
        level: the dataset, 1 … 20; 0 is the reference speed and noise alone, without backlash or gravity.
        noise: "low" or "high".
        draw: the number of the realisation; with the other two arguments it determines the noise and the start.

    Raises:
        BenchError: for an unknown level or noise, and a draw that is not a whole number of at least 0.
    """
    if level not in (0, *LEVELS):
        raise BenchError(f"a noisy dataset has a level from 0 (no backlash) to {LEVELS[-1]}, not {level!r}")
    if noise not in NOISES:
        raise BenchError(f"noise must be one of {', '.join(map(repr, NOISES))}, not {noise!r}")
    require_whole("draw", draw, 0)
    rng = np.random.default_rng([level, NOISES.index(noise), draw])
    clean = dataset(level or LEVELS[0])
    if not level:  # of this dataset only the length is used
        clean = Recording(0.0, clean.dt, np.full_like(clean.speed, DEFAULT.nominal_speed), peak=0.0)
    cut = int(rng.integers(FIRST_SAMPLES))
    return replace(clean, speed=with_noise(clean.speed, peak_to_peak(level, noise), rng)[cut:])


def simulated(gap: float, joint: Joint = DEFAULT) -> Recording:
    """Return a joint's recording at a half-gap in rad: 2401 samples at 500 Hz, or two load turns if these take longer.

    Raises:
        BenchError: as :func:`problems.backlash.joint.simulate`.
    """
    made = simulate(joint, half_gap=gap, duration=max(4.8, 2 * joint.turn), rate=RATE)
    return Recording(0.0, 1 / RATE, made.speed, peak=made.peak, half_gap=gap)
