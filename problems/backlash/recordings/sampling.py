"""Bring samples to equal steps of time: positions that wrap, repeated stamps, missing samples, jitter, high rates."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash.recordings.recording import Recording

MOST_REPEATED = 0.01  # the largest share of samples whose time stamp is that of the sample before
MOST_MISSING = 0.01  # the largest share of samples that are missing
LONGEST_GAP = 0.01  # s, or two samples and a half; an oscillation of 25 Hz turns by a quarter in it
RATE = 500.0  # Hz, to which faster recordings are averaged down: the signature rings at up to 40 Hz (Table 7.1)


def unwrapped(position: Floats, turn: float) -> Floats:
    """Return a position (N,) in any unit, of which one turn is ``turn``, without the jumps of one that wraps at a turn.

    Successive samples must differ by less than half a turn.
    """
    if np.ptp(position) > turn * (1.0 + 1e-6):
        return position
    steps = np.diff(position, prepend=position[0])
    laps = np.cumsum(np.rint(steps / turn))
    return position - turn * laps


def merged(time: Floats, values: Floats) -> tuple[NDArray[np.intp], Floats, str]:
    """Return the first sample (M,) of each run of equal times, the mean value of each run, and a sentence on it.

    Every sample is a run of its own where no time is repeated, or more than ``MOST_REPEATED`` of them.
    """
    first = np.diff(time, prepend=-np.inf) != 0
    repeated = int((~first).sum())
    if not 0 < repeated <= MOST_REPEATED * len(time):
        return np.arange(len(time)), values, ""
    run = np.cumsum(first) - 1
    means = np.bincount(run, values) / np.bincount(run)
    stamps = "1 time stamp is" if repeated == 1 else f"{repeated} time stamps are"
    return np.flatnonzero(first), means, f"{stamps} repeated, and samples of one time stamp were averaged"


def uniform(time: Floats, values: Floats) -> tuple[float, Floats, str]:
    """Return the step (s) of a uniform time, the values (M,) at it from the first time on, and a sentence on it.

    Values are left as they are where each time is within a quarter of a step of the uniform one. Else they are
    interpolated; a step of more than one and a half usual ones is a gap.

    Args:
        time: (N,) s, increasing.
        values: (N,) finite.

    Raises:
        BenchError: where too many samples are missing, or too many in a row, with the gap's size.
    """
    steps, whole = np.diff(time), float(time[-1] - time[0])
    dt = whole / len(steps)
    if (np.abs(time - (time[0] + dt * np.arange(len(time)))) <= 0.25 * dt).all():
        return dt, values, ""
    laps = steps / np.median(steps)
    missing = int(np.maximum(np.rint(laps[laps > 1.5]) - 1, 1).sum())
    dt = whole / (len(steps) + missing)
    if missing > MOST_MISSING * len(time) or steps.max() > max(2.5 * dt, LONGEST_GAP):
        raise BenchError(f"steps of {steps.min():.6g} to {steps.max():.6g} s, where {dt:.6g} s is usual")
    from scipy.interpolate import PchipInterpolator  # 0.2 s, which a uniform recording need not wait for

    grid = time[0] + dt * np.arange(len(steps) + missing + 1)
    samples: Floats = PchipInterpolator(time, values)(np.minimum(grid, time[-1]))
    what = f"{missing} of {len(grid)} samples are missing" if missing else "the time steps are unequal"
    return dt, samples, f"{what}; the recording was resampled to equal steps"


def averaged_down(recording: Recording) -> tuple[Recording, str]:
    """Return a recording at ``RATE`` or a little more, and a sentence on it where the recording is faster.

    A low-pass filter keeps what rings at less than half that rate from showing up as something slower.
    """
    every = int(1.0 / (recording.dt * RATE) * (1.0 + 1e-9))
    if every < 2:
        return recording, ""
    from scipy.signal import resample_poly  # 0.5 s, which a slow recording need not wait for

    speed = resample_poly(recording.speed, 1, every, padtype="line")
    slow = replace(recording, dt=recording.dt * every, speed=speed)
    return slow, f"the recording was averaged down from {1 / recording.dt:.5g} to {1 / slow.dt:.5g} Hz"
