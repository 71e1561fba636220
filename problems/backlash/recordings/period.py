"""Find the time of one load turn, T_f, from the gear ratio or from the disturbance itself.

    >>> period_from_gear(recording, 40)  # by the mean speed, where the gear ratio is known
    >>> find_period(recording)  # from the signal, None where it has no period

The second half of a load turn repeats the first with the opposite sign (thesis section 3.3): f(t + T_f/2) = -f(t), so
f has the odd harmonics of 1/T_f alone. This distinguishes T_f from its multiples and parts: the odd harmonics of
1/(2 T_f) and 2/T_f are not harmonics of f, those of 3/T_f are a third of f's, and those of 1/(3 T_f) are three times as
many as f has. The search fits the odd harmonics of each period to the signal and takes the period of the best fit by
Schwarz's criterion (Annals of Statistics 6, 1978, doi:10.1214/aos/1176344136); least squares in T_f and the harmonics
together then make it exact (Quinn and Hannan, The Estimation and Tracking of Frequency, 2001, chapter 4).
"""

from math import log, pi

import numpy as np

from bench.contract.numbers import require_positive
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash.recordings.recording import Recording
from problems.backlash.recordings.screen import SAMPLES_A_TURN

RATE = 250.0  # Hz; the signal is averaged down to this sampling rate or a little more, for the harmonics up to BAND
BAND = 50.0  # Hz; the disturbance rings at up to 40 Hz (Table 7.1)
LONGEST = 8_192  # the most averaged samples that are used, from the start of the recording on: 33 s at least
LONGEST_PERIOD = 20.0  # s; the longest load turn that the search covers
FEWEST_TURNS = 2.0  # the load turns that a recording must hold for the search to find its period
STRONGEST = 24  # the number of harmonics that make a period exact, the strongest ones
CLAIM = 12.0  # the gain in log-likelihood, after Schwarz's allowance, from which on a period is reported
FLOOR = 0.02  # the smallest part of the signal's energy that counts as noise: a search misses so much of a period


def find_period(recording: Recording) -> float | None:
    """Return the time of one load turn in s, the period of the disturbance, or None where the signal shows none.

    The recording, at a steady speed, must hold two turns.
    """
    spectrum = _Spectrum(recording)
    frequency = spectrum.search(SAMPLES_A_TURN * recording.dt)
    return None if frequency is None else _rounded(*spectrum.refine(frequency), recording)


def period_from_gear(recording: Recording, gear_ratio: float) -> float:
    """Return the time of one load turn in s: the motor turns in one over the mean speed, of whole load turns.

    It is known where the signal shows no disturbance, too.

    Raises:
        BenchError: for a gear ratio that is not a positive number, and for a mean speed of 0.
    """
    require_positive("the gear ratio", gear_ratio)
    speed = recording.speed
    mean = abs(float(speed.mean()))
    if mean == 0.0:
        raise BenchError("the mean speed is 0 rps, which gives no time of a load turn; cut out a steady part")
    turn = gear_ratio / mean / recording.dt  # in samples
    if turn <= len(speed):
        speed = speed[: round(int(len(speed) / turn) * turn)]
    mean = abs(float(speed.mean()))
    seconds = gear_ratio / mean
    return _rounded(seconds, seconds * float(speed.std()) / mean / len(speed) ** 0.5, recording)


def _rounded(seconds: float, error: float, recording: Recording) -> float:
    """Return a period in s rounded to a whole number of samples in half a turn, which makes the fit faster.

    It is left as it is where that changes it by more than two standard errors and shifts the last turn by a quarter of
    a sample or more.
    """
    nearest = 2 * recording.dt * max(1, round(seconds / (2 * recording.dt)))
    whole = abs(nearest - seconds) <= max(2 * error, 0.25 * recording.dt * seconds / recording.duration)
    return nearest if whole else seconds


class _Spectrum:
    """The spectrum of a signal up to BAND, and the fit of a period's odd harmonics by it."""

    def __init__(self, recording: Recording) -> None:
        every = max(1, int(1 / (recording.dt * RATE)))
        count = min(len(recording.speed) // every, LONGEST)
        self._dt = recording.dt * every
        self._time = self._dt * (np.arange(count) - (count - 1) / 2)
        means = recording.speed[: count * every].reshape(count, every).mean(axis=1)
        self._signal: Floats = means - np.polynomial.Polynomial.fit(self._time, means, 1)(self._time)
        self._duration = self._dt * count
        self._band = min(BAND, 0.4 / self._dt)

        window = np.hanning(count + 2)[1:-1]  # so that a strong harmonic does not spread over its neighbours
        padded = 1 << int(np.ceil(np.log2(16 * count)))
        spectrum = np.abs(np.fft.rfft(window * self._signal, padded)) ** 2
        self._step = 1 / (padded * self._dt)
        self._power = spectrum * 2 * count / window.sum() ** 2  # the energy of a sinusoid there
        inside = spectrum[: int(self._band / self._step) + 1]
        self._energy = float(2 * inside.sum() / padded * count / (window**2).sum())
        self._values = 2 * self._band * self._duration / 1.5  # independent values in the band, with this window

    def _gain(self, frequency: Floats) -> Floats:
        """Return the gain in log-likelihood over noise, (m,), of (m,) ascending 1/T_f, less Schwarz's allowance."""
        odd, harmonics = self._comb(frequency, 1)
        part = np.minimum(odd / self._energy, 1.0)
        gain = -self._values / 2 * np.log((1 - part + FLOOR) / (1 + FLOOR)) - harmonics * log(self._values)
        likely = gain > CLAIM
        if likely.any():
            even, _ = self._comb(frequency[likely], 2)
            gain[likely] = np.where(odd[likely] > 3 * even, gain[likely], -np.inf)  # slow noise has both
        return gain

    def search(self, shortest: float) -> float | None:
        """Return 1/T_f in Hz of the best period from a limit in s on; None where no period beats noise."""
        longest = min(LONGEST_PERIOD, self._duration / FEWEST_TURNS)
        shortest = max(shortest, 3 / self._band)
        if not shortest < longest:
            return None
        fine = 8 * self._duration * self._band  # at the band's end, two steps are an eighth of the resolution
        frequency = np.geomspace(1 / longest, 1 / shortest, int(fine * log(longest / shortest)) + 2)
        gain = self._gain(frequency)
        best = int(np.argmax(gain))
        return float(frequency[best]) if gain[best] > CLAIM else None

    def refine(self, frequency: float) -> tuple[float, float]:
        """Return the period (s) that fits best near a frequency (Hz), by Gauss-Newton steps, and its standard error."""
        k = np.arange(1, int(self._band / frequency) + 1, 2)
        strongest = np.argsort(self._power[np.rint(k * frequency / self._step).astype(int)])[-STRONGEST:]
        k = k[strongest]
        line = np.column_stack([np.ones_like(self._time), self._time])
        for _ in range(3):
            phase = 2 * pi * frequency * np.outer(self._time, k)
            cos, sin = np.cos(phase), np.sin(phase)
            waves = np.hstack([line, cos, sin])
            a, b = np.split(np.linalg.solve(waves.T @ waves, waves.T @ self._signal)[2:], 2)
            slope = 2 * pi * self._time * ((cos * b - sin * a) @ k)  # of the fit, with the frequency
            design = np.column_stack([waves, slope])
            inverse = np.linalg.inv(design.T @ design)
            solution = inverse @ (design.T @ self._signal)
            frequency += float(solution[-1])
        residual = self._signal - design @ solution
        variance = float(residual @ residual) / max(1, len(residual) - len(solution)) * float(inverse[-1, -1])
        return 1 / frequency, variance**0.5 / frequency**2

    def _comb(self, frequency: Floats, first: int) -> tuple[Floats, Floats]:
        """Return the energy at every second harmonic from ``first`` on, and their number, for (m,) ascending 1/T_f."""
        energy, count = np.zeros_like(frequency), np.zeros_like(frequency)
        for k in range(first, int(self._band / frequency[0]) + 1, 2):
            inside = int(np.searchsorted(frequency, self._band / k, side="right"))
            energy[:inside] += self._power[(frequency[:inside] * (k / self._step) + 0.5).astype(np.int64)]
            count[:inside] += 1
        return energy, count
