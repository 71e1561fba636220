"""Check whether a recording is fit for the signature fit, and warn of what may spoil an estimate.

>>> screen(recording, period=0.4)  # raises BenchError where the recording cannot be used
>>> warnings(recording, period=0.4)  # sentences on a recording that can be used
"""

from collections.abc import Iterator
from math import floor

import numpy as np
from numpy.typing import NDArray

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash.recordings.headings import UNITS
from problems.backlash.recordings.recording import Recording, spell

FASTEST = 1000.0  # rps; no joint's motor turns at 60,000 rpm
STEADY = 0.2  # the largest deviation of a steady speed, as a part of the mean; the disturbance is a few percent of it
GUARD = 0.05  # s; a ramp takes about as long to pass through the range of the disturbance
SAMPLES_A_TURN = 20  # the fewest samples in one load turn: the disturbance rings several times a turn
RUN = 3  # the fewest successive samples at the extreme that may be a clipped peak
# Steps of resolution by which a clipped peak's neighbours lie below it. A round peak, of which n >= 3 samples are
# rounded to one value, falls by at most ((n + 1) / (n - 1))**2 + 1 <= 5 steps beside them.
DROP = 6.0


def screen(recording: Recording, *, period: float | None = None) -> None:
    """Raise BenchError, in one sentence, for the first thing that makes a recording unfit.

    In this order: values that are not numbers, a constant speed, a speed in another unit, a speed that is not steady (a
    start, a stop, a reversal), a clipped speed, less than one load turn, and a sampling that is too coarse.
    Missing samples are reported when a recording is read.

    Args:
        recording: the recording.
        period: T_f, the time of one load turn, s; None where it is not known, or a single oscillation is to be fitted.
    """
    screen_values(recording)
    _screen_unit(recording)
    _screen_steadiness(recording)
    screen_clipping(recording)
    if period is not None:
        screen_length(recording, period)
        screen_sampling(recording, period)


def warnings(recording: Recording, *, period: float | None = None) -> list[str]:
    """Return a sentence on everything in a screened recording that is not an error but may spoil an estimate."""
    assumed = [recording.assumed] if recording.assumed else []
    return [*assumed, *_warn_of_ends(recording), *_warn_of_samples(recording), *_warn_of_turns(recording, period)]


def drift(recording: Recording) -> float:
    """Return the drift of the mean speed (rps) from the first sample to the last; 0 for a small drift.

    A drift is small up to half of the speed's range about a straight line.
    """
    speed = _running_median(recording.speed)
    time = np.linspace(-0.5, 0.5, len(speed))
    change = float(np.polynomial.polynomial.polyfit(time, speed, 1)[1])
    low, high = np.quantile(speed - change * time, (0.05, 0.95))
    return change if abs(change) > 0.5 * (high - low) else 0.0


def steady_window(recording: Recording) -> tuple[float, float] | None:
    """Return the ends (s) of the longest part in which the speed is steady, without a transient at its ends, or None.

    A speed is steady that stays within 20% of its level. An end where the motor starts or stops, or the speed leaves
    the range of the part's middle half by more than that range, is cut back to where the speed leaves it by no more
    than a tenth, and by ``GUARD`` further, so that a ramp or a transient is left out.
    """
    speed = _running_median(recording.speed)
    first = end = 0
    for level in np.quantile(speed, np.linspace(0.025, 0.975, 20)):
        starts, ends = _runs(np.abs(speed - level) <= STEADY * abs(level))
        if (ends - starts).max(initial=0) > end - first:
            longest = np.argmax(ends - starts)
            first, end = int(starts[longest]), int(ends[longest])
    quarter = (end - first) // 4
    middle = speed[first + quarter : end - quarter]
    if len(middle) < 2:
        return None
    low, high = middle.min(), middle.max()
    span = max(high - low, 0.01 * abs(high))
    cuts = []
    for side, moves in ((speed[first:end], first > 0), (speed[first:end][::-1], end < len(speed))):
        beyond = np.maximum(low - side, side - high)[: quarter + 1]
        is_cut = moves or (beyond > span).any()
        last = int(np.flatnonzero(beyond > 0.1 * span).max(initial=-1)) + 1
        cuts.append(last + min(round(GUARD / recording.dt), quarter // 2) if is_cut else 0)
    first, end = first + cuts[0], end - cuts[1]
    time = recording.time
    return float(time[first]), float(time[end - 1])


def screen_values(recording: Recording) -> None:
    """Raise BenchError for a speed that is constant or has a value that is not a number."""
    bad = ~np.isfinite(recording.speed)
    if bad.any():
        where = recording.start + recording.dt * int(np.argmax(bad))
        raise BenchError(f"the speed at {where:.6g} s is not a number; fix the recording or cut out a part without it")
    if np.ptp(recording.speed) <= 1e-9 * np.abs(recording.speed).max():  # rounding, after a change of unit
        raise BenchError(
            f"the speed is constant at {recording.speed[0]:.6g} rps, so there is no disturbance to fit; record with "
            "more digits, or a joint that turns"
        )


def _screen_unit(recording: Recording) -> None:
    speed = float(np.median(np.abs(recording.speed)))
    if speed > FASTEST:
        units = next(units for units in (UNITS["speed"], UNITS["position"]) if recording.unit in units)
        raise BenchError(
            f"a speed of {speed:.6g} rps is more than a motor has; say in which unit the recording is "
            f"(--unit {', '.join(units)}), which was read as {recording.unit}"
        )


def _screen_steadiness(recording: Recording) -> None:
    speed = _running_median(recording.speed)
    level = float(np.median(speed))
    off = np.abs(speed - level) > STEADY * abs(level)
    if not off.any():
        return
    if speed.min() < 0.0 < speed.max():
        what = "reverses"
    elif np.abs(speed).min() < STEADY * np.abs(speed).max():
        what = "starts or stops"
    else:
        what = "leaves its speed by more than a fifth"
    window = steady_window(recording)
    if window is None or window[1] - window[0] < 0.02 * recording.duration:
        advice = "record at a constant speed, which must be many times the disturbance"
    else:
        advice = f"take its longest steady part, --window {spell(*window)}"
    raise BenchError(f"the motor {what} (its speed is {speed.min():.4g} to {speed.max():.4g} rps); {advice}")


def screen_clipping(recording: Recording) -> None:
    """Raise BenchError for a speed that stays at its highest or lowest value, as a sensor at its limit gives."""
    for name, side in (("highest", 1.0), ("lowest", -1.0)):
        clipped = _clipped(side * recording.speed)
        if clipped is not None:
            count, first = clipped
            raise BenchError(
                f"the speed is clipped: {count} samples lie in flat runs at its {name} value, "
                f"{recording.speed[first]:.6g} rps, the first at {recording.start + recording.dt * first:.6g} s; "
                "record with a larger range"
            )


def screen_length(recording: Recording, period: float) -> None:
    """Raise BenchError for less than one load turn of ``period`` s."""
    if recording.duration < period * (1.0 - 1e-9):
        raise BenchError(
            f"the recording lasts {recording.duration:.4g} s, less than one load turn of {period:g} s; record longer, "
            "give the right period, or fit a single oscillation"
        )


def screen_sampling(recording: Recording, period: float) -> None:
    """Raise BenchError for too few samples in a load turn of ``period`` s."""
    if recording.dt > period / SAMPLES_A_TURN * (1.0 + 1e-9):
        raise BenchError(
            f"a sample every {recording.dt:.4g} s is too coarse for a load turn of {period:g} s; sample at "
            f"{SAMPLES_A_TURN / period:.4g} Hz at least"
        )


def _clipped(speed: Floats) -> tuple[int, int] | None:
    """Return how many samples lie in runs at a clipped maximum and where the first begins, or None for a natural one.

    A sensor at its limit gives the same value in many successive samples, with a jump before and after them, and gives
    it more often than the values just below. None of these signs is enough alone: a rounded smooth peak is flat, one
    period may repeat another to the last digit, and a coarse quantisation leaves few values.
    """
    top = float(speed.max())
    # Values far below the top are left out: 99.987 and 100.12, of five digits each, differ by unequal steps.
    near = speed[speed > (top + float(np.median(speed))) / 2]
    gaps = np.diff(np.unique(near))
    tiny = 1e-9 * max(abs(top), 1.0)  # one value after a change of unit
    gaps = gaps[gaps > tiny]
    if not len(gaps):  # the next value is too far down to distinguish a jump from a step
        return None
    step = float(gaps.min())
    at_top = speed >= top - tiny
    starts, ends = _runs(at_top)
    padded = np.concatenate(([-np.inf], speed, [-np.inf]))
    jumps = top - np.maximum(padded[starts], padded[ends + 1])  # of the nearer neighbour
    flat = (ends - starts >= RUN) & (jumps > DROP * step)
    longest = int((ends - starts)[flat].max(initial=0))
    count = int((ends - starts)[flat].sum())
    below = int(((speed < top - tiny) & (speed > top - (DROP + 0.5) * step)).sum())
    if (flat.sum() >= 2 or longest > RUN + 1) and count > below:
        return count, int(starts[flat][0])
    return None


def _warn_of_ends(recording: Recording) -> Iterator[str]:
    window = steady_window(recording)
    slack = 2 * recording.dt
    end = recording.start + recording.duration
    if window is not None and (window[0] > recording.start + slack or window[1] < end - slack):
        yield f"the speed is not yet, or no longer, steady at the ends; think of --window {spell(*window)}"
    if line := drift(recording):
        yield f"the mean speed drifts by {line:.3g} rps over the recording; a straight line is taken off"


def _warn_of_samples(recording: Recording) -> Iterator[str]:
    speed = recording.speed
    jumps = np.abs(speed - _running_median(speed, 3))  # a median of five would flatten ringing at 21 Hz
    low, high = np.quantile(speed, (0.01, 0.99))
    spikes = jumps > max(high - low, 12.0 * float(np.median(jumps)))
    if 0 < spikes.sum() <= max(3.0, 0.002 * len(speed)):  # more spikes than that belong to the signal
        where = recording.start + recording.dt * int(np.argmax(spikes))
        count = int(spikes.sum())
        yield f"{count} lone {'samples stick' if count > 1 else 'sample sticks'} far out, the first at {where:.6g} s"
    values = np.unique(speed)
    steps = np.diff(values)
    step = float(np.median(steps[steps > 1e-9 * np.abs(values).max()])) if len(steps) else 0.0
    if step > 0.1 * np.ptp(speed):
        yield (
            f"the speed comes in steps of {step:.3g} rps, a large part of its range of {np.ptp(speed):.3g} rps: small "
            "disturbances are lost in them; use a finer encoder or a lower sampling rate"
        )


def _warn_of_turns(recording: Recording, period: float | None) -> Iterator[str]:
    turns = recording.duration / period if period else np.inf
    if turns < 3:
        held = floor(10 * turns) / 10
        yield f"the recording holds {held:g} load turn{'s' * (held != 1)}; three or more make an estimate firmer"


def _running_median(values: Floats, size: int = 5) -> Floats:
    """Return the (N,) medians of the ``size`` values about each one; the first and the last value are continued.

    A median of five removes one or two bad samples in a row.
    """
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, size // 2, mode="edge"), size)
    medians: Floats = np.partition(windows, size // 2, axis=1)[:, size // 2]
    return medians


def _runs(flags: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first index of each run of true flags, and the index after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False]))))
    return edges[::2], edges[1::2]
