"""Find where samples are lost without a gap in time: from there on all impacts come early.

A logger that numbers its rows leaves no gap. Folded, such a recording has the impacts of several phases on top of one
another, which may cancel. So the recording is cut into parts of an eighth of a load turn, and each part gets the phase
in one common load turn that fits it best, where a change of phase from part to part costs as much as it would gain by
chance: the cheapest sequence of phases (Viterbi 1967). Load turn and phases are found in turns, from every two
successive load turns. With the lost samples put back, impacts must explain most of what repeats, and far more than
noise, so that neither tones nor noise, whose phases change as well, are taken for a broken train.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit

from bench.contract.typing import Floats
from problems.backlash.recordings import Recording
from problems.backlash.sensor.load_turn import BAND, fold

PARTS = 8  # of a load turn, each of one phase
PLACES = 6 * BAND  # phases a second of a load turn
STARTS = 16  # load turns to begin with, at most
ROUNDS = 3  # of load turn and phases
JUMP = 25.0  # the log-likelihood that a jump costs: one of some 10,000 changes, and noise is not white
STEP = 3.0  # what a change to the next phase costs, as a period that is not exact asks for
LEAST = 2  # places; smaller changes are no jumps
SHORTEST = 3  # parts between two jumps; else they are one
GAIN = 400.0  # of the impacts with the lost samples put back; noise, with phases chosen for it, has up to 200
MISFIT = 0.01  # the part of the signal's mean square that counts as noise


@dataclass(frozen=True)
class Lost:
    """Samples that are lost.

    Attributes:
        times: (m,) where, s, to half a load turn or so.
        part: the longest part between them in s, half a load turn from both.
    """

    times: tuple[float, ...]
    part: tuple[float, float]

    def __str__(self) -> str:
        """Return in a sentence where samples are lost, and what to do."""
        *first, last = (f"{time:.3g}" for time in self.times)
        where = f"{', '.join(first)} and {last}" if first else last
        begin, end = (f"{time:.3g}" for time in self.part)
        return (
            f"samples are lost near {where} s, where the phase of the impacts jumps, so no half-gap is inferred; "
            f"record again, or take the longest part without a jump, --window {begin}:{end}"
        )


def lost_samples(recording: Recording, period: float) -> Lost | None:
    """Return where samples of a recording of two load turns or more are lost, or None for nowhere."""
    size = math.ceil(PLACES * period / PARTS)  # of a part
    step = period / (PARTS * size)
    count = int(recording.duration / step / size + 1e-6)
    time = recording.start + step * np.arange(count * size)
    parts = np.interp(time, recording.time, _in_band(recording, period)).reshape(count, size)
    if count < 2 * PARTS + 1:
        return None
    energy = (parts[PARTS:] - parts[:-PARTS]) ** 2 / 2
    noise = float(np.median(energy.mean(axis=1))) + MISFIT * float((parts**2).mean())
    weight = min(1.0, 2 * BAND * step) / (2 * noise)  # of a square: samples are closer together than independent ones
    best, phases, turn = math.inf, np.zeros(count, dtype=int), parts[:0]
    last = count - 2 * PARTS
    for first in np.linspace(0, last, min(STARTS, last // (PARTS // 2) + 1), dtype=int):
        own = np.roll(parts[first : first + 2 * PARTS].reshape(2, -1).mean(axis=0), first % PARTS * size)
        for _ in range(ROUNDS):
            cost, found = _cheapest(parts, own, weight)
            if cost < best:
                best, phases, turn = cost, found, own
            own = _mean_turn(parts, found)
    jumps = _jumps(phases, PARTS * size)
    if not jumps:
        return None
    whole = fold(Recording(0.0, step, _put_back(parts, phases, turn)), period)
    if not whole.impacting or whole.impacts.gain < GAIN:
        return None
    ends = [-PARTS // 2, *jumps, count + PARTS // 2]
    longest = int(np.argmax(np.diff(ends)))
    part = (ends[longest] + PARTS // 2, ends[longest + 1] - PARTS // 2)
    return Lost(
        tuple(recording.start + step * size * jump for jump in jumps),
        (recording.start + step * size * part[0], recording.start + step * size * part[1]),
    )


def _in_band(recording: Recording, period: float) -> Floats:
    """Return the speed (N,) without what is slower than the load turn's second harmonic or faster than ``BAND``."""
    spectrum = np.fft.rfft(recording.speed - recording.speed.mean())
    frequency = np.fft.rfftfreq(len(recording.speed), recording.dt)
    spectrum[(frequency < 1.5 / period) | (frequency > BAND)] = 0.0
    return np.fft.irfft(spectrum, len(recording.speed))


def _cheapest(parts: Floats, turn: Floats, weight: float) -> tuple[float, np.ndarray]:
    """Return the cost of the cheapest sequence of phases, and each part's phase (m,) in places of the turn."""
    count, size = parts.shape
    places = len(turn)
    windows = turn[np.add.outer(np.arange(places), np.arange(size)) % places]
    costs = (parts**2).sum(axis=1)[:, np.newaxis] - 2 * parts @ windows.T + (windows**2).sum(axis=1)
    at = np.add.outer(size * np.arange(count), np.arange(places)) % places
    costs = weight * np.take_along_axis(costs, at, axis=1)
    found: tuple[float, np.ndarray] = _sequence(costs)
    return found


@njit(cache=True)
def _sequence(costs: Floats) -> tuple[float, np.ndarray]:
    """Return the cost of the cheapest way through costs (m, places), and the place that it has in each row (m,)."""
    count, places = costs.shape
    total = costs[0].copy()
    came = np.empty((count, places), dtype=np.int64)
    for i in range(1, count):
        before, least = total.copy(), int(np.argmin(total))
        for place in range(places):
            way, cost = place, before[place]
            for other, change in (((place - 1) % places, STEP), ((place + 1) % places, STEP), (least, JUMP)):
                if before[other] + change < cost:
                    way, cost = other, before[other] + change
            came[i, place], total[place] = way, cost + costs[i, place]
    phases = np.empty(count, dtype=np.int64)
    phases[-1] = np.argmin(total)
    for i in range(count - 1, 0, -1):
        phases[i - 1] = came[i, phases[i]]
    return total.min(), phases


def _mean_turn(parts: Floats, phases: np.ndarray) -> Floats:
    """Return the mean load turn of parts with these phases."""
    count, size = parts.shape
    places = PARTS * size
    at = (np.add.outer(size * np.arange(count) + phases, np.arange(size)) % places).ravel()
    mean: Floats = np.bincount(at, parts.ravel(), places) / np.maximum(np.bincount(at, minlength=places), 1)
    return mean


def _change(before: int, after: int, places: int) -> int:
    """Return the change from one phase to another in places: forward, but a small one backward is negative."""
    change = int(after - before) % places
    return change - places if places - change < LEAST else change


def _jumps(phases: np.ndarray, places: int) -> list[int]:
    """Return the parts at which the phase jumps."""
    jumps: list[int] = []
    before = phases[0]
    for i in range(1, len(phases)):
        if abs(_change(phases[i - 1], phases[i], places)) < LEAST:
            continue
        if jumps and i - jumps[-1] < SHORTEST:
            if abs(_change(before, phases[i], places)) < LEAST:
                jumps.pop()
            continue
        before = phases[i - 1]
        jumps.append(i)
    return jumps


def _put_back(parts: Floats, phases: np.ndarray, turn: Floats) -> Floats:
    """Return the samples with the lost ones put back from the load turn."""
    count, size = parts.shape
    changes = [_change(a, b, len(turn)) for a, b in pairwise(phases)]
    late = np.concatenate([[0], np.cumsum(changes)])
    late -= late.min()
    whole: Floats = turn[(np.arange(count * size + late.max()) + phases[0] - late[0]) % len(turn)]
    for i, part in enumerate(parts):
        whole[i * size + late[i] : (i + 1) * size + late[i]] = part
    return whole
