"""Test whether what repeats every load turn is a train of impacts, and find the time T_d between its two impacts.

A recording of n load turns, folded at T_f, has the spectrum of one turn at every n-th line of its own; the lines in
between are noise, or tones that do not turn with the load. Each harmonic k / T_f so has a noise level of its own,
whatever the colour of the noise. The first harmonic, the load's ripple, is left out. The others, weighted by their
noise, are compared with

1. *impacts*: a damped oscillation and its opposite T_d later, of the best onset, tau and omega of a grid, its sine and
   cosine solved for. T_d is T_f / 2 unless another value explains clearly more: Coulomb friction c delays one change of
   flank and hastens the other, by asin(c / m g l) of a load turn each.
2. *steady tones*: the strongest harmonics alone, as many parameters as the impacts have.

It is a backlash where impacts explain more than noise may, more than steady tones do, and most of what repeats.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from bench.contract.typing import Floats
from problems.backlash.recordings import Recording
from problems.backlash.sensor.evidence import BENCH, SIGNIFICANT
from problems.backlash.signature.model import T0, V_T, oscillation

BAND = 60.0  # Hz; the harmonics up to it count: the disturbance rings at up to 40 Hz (Table 7.1)
FEWEST = 8  # harmonics that distinguish impacts from tones at least
BESIDE = 5  # lines to both sides of a harmonic that show its noise, at most
TAUS, OMEGAS = np.array([5.0, 9.0, 15.0, 30.0]), 2 * np.pi * np.arange(5.0, 41.0)  # the grid, 1/s and rad/s
STEPS = 4  # places of an onset in half a period of the highest harmonic
FINER = 8  # further places between two of them, for T_d
SHORTEST = 0.3  # T_d as a part of T_f at least: friction of up to 59% of gravity's torque
ASKED = 15.0  # the gain (twice a log-likelihood) from which on another T_d than T_f / 2 is taken
BEFORE = 1 / 8  # of the shorter part of a load turn lies before its impact
FAINT = 1e-3  # rps; an amplitude that counts as noise, as one count of a 19-bit encoder makes it at 500 Hz
MISFIT = 0.01  # the part of a mean harmonic's energy that counts as noise: impacts are no exact damped sines
TONES = 3  # steady tones that are compared with impacts
MOST = 0.8  # the share of what repeats that impacts explain at least


class Impacts(NamedTuple):
    """The best impacts: the gain over noise, twice a log-likelihood, with tau, omega, and onset and T_d in turns."""

    gain: float
    tau: float
    omega: float
    onset: float
    delay: float


@dataclass(frozen=True, eq=False)
class LoadTurn:
    """The harmonics of one load turn.

    Attributes:
        period: T_f in s.
        turns: n, the whole load turns that were folded.
        order: (m,) the harmonics' numbers, from 2 on.
        value: (m,) their complex amplitudes, rps.
        noise: (m,) the mean squared magnitude of their noise.
        ripple: the amplitude of the first harmonic, the load's ripple, rps.
    """

    period: float
    turns: int
    order: Floats
    value: np.ndarray
    noise: Floats
    ripple: float

    @cached_property
    def weight(self) -> Floats:
        """(m,) the weight of a harmonic's squared magnitude, so that the sum over noise is 2 m in the mean."""
        weight: Floats = 2 / (self.noise + (FAINT / 2) ** 2 + MISFIT * np.mean(np.abs(self.value) ** 2))
        return weight

    @cached_property
    def energy(self) -> Floats:
        """(m,) the weighted energy of each harmonic."""
        energy: Floats = self.weight * np.abs(self.value) ** 2
        return energy

    @cached_property
    def impacts(self) -> Impacts:
        """The best impacts, with T_d = T_f / 2 unless the harmonics ask for another."""
        return self._free if self._free.gain > self._even.gain + ASKED else self._even

    @property
    def p_value(self) -> float:
        """The adjusted p-value of the impacts: that noise alone gives so good ones (Bonferroni)."""
        return self._chance(self.impacts.gain)

    @property
    def share(self) -> float:
        """The share of what repeats, less its noise, that the impacts explain."""
        return self.impacts.gain / max(float(self.energy.sum()) - 2 * len(self.order), self.impacts.gain)

    @property
    def steady(self) -> bool:
        """Whether steady tones explain as much as the impacts."""
        return float(np.sort(self.energy)[-TONES:].sum()) >= self.impacts.gain

    @property
    def loudest(self) -> float:
        """The frequency of the strongest harmonic, Hz."""
        return float(self.order[np.argmax(self.energy)] / self.period)

    @property
    def impacting(self) -> bool:
        """Whether what repeats is a train of impacts: detected, no steady tones, and most of it."""
        return self.p_value <= SIGNIFICANT and not self.steady and self.share >= MOST

    @property
    def friction(self) -> float:
        """The Coulomb friction, as a part of gravity's torque, that gives this T_d."""
        return math.sin(math.pi * abs(0.5 - self.impacts.delay))

    @property
    def ringing(self) -> float:
        """The frequency of the impacts, Hz: the vertex of a parabola through the gains at three of the grid's."""
        at, places = self.impacts, self._places * FINER
        shift, step = round(at.delay * places), float(OMEGAS[1] - OMEGAS[0])
        below, best, above = (self._best([(at.tau, at.omega + k * step)], places, [shift]).gain for k in (-1, 0, 1))
        vertex = (above - below) / max(2 * (2 * best - below - above), 1e-12 * best)
        return (at.omega + min(max(vertex, -1.0), 1.0) * step) / (2 * math.pi)

    @property
    def detectable(self) -> float:
        """The smallest detectable amplitude of the bench's usual signature, rps; infinite without enough harmonics."""
        if len(self.order) < FEWEST:
            return math.inf
        needed = self._freedom * ((self._looks / SIGNIFICANT) ** (2 / self._freedom) - 1)
        return math.sqrt(needed / self._usual_gain)

    @property
    def amplitude(self) -> float:
        """The amplitude in rps of the bench's usual signature that has the impacts' gain."""
        return math.sqrt(self.impacts.gain / self._usual_gain)

    def without_tones(self) -> "LoadTurn | None":
        """Return the load turn without the tones that hide its impacts, or None where the rest is no noise either."""
        rest = self
        for _ in range(TONES):
            kept = np.arange(len(rest.order)) != np.argmax(rest.energy)
            rest = replace(rest, order=rest.order[kept], value=rest.value[kept], noise=rest.noise[kept])
            if rest.p_value > SIGNIFICANT:
                return rest
        return None

    @property
    def _usual_gain(self) -> float:
        """The gain of the bench's usual signature of 1 rps, with this T_d."""
        _, tau, omega, t1 = BENCH
        apart = 1 - np.exp(-2j * np.pi * self.order * self.impacts.delay)
        wave = math.exp(tau * t1) * self._ringing(tau, omega)[0] * apart
        return float(self.weight @ np.abs(wave) ** 2)

    @property
    def _looks(self) -> float:
        return float(self._places * len(TAUS) * len(OMEGAS))

    @property
    def _freedom(self) -> float:
        """The degrees of freedom of the noise under the three strongest harmonics of an oscillation."""
        return 6.0 * 2 * min(BESIDE, self.turns - 1)

    @property
    def _places(self) -> int:
        """The number of onsets in a load turn, a power of two."""
        return 1 << math.ceil(math.log2(2 * STEPS * float(self.order[-1])))

    def _chance(self, gain: float) -> float:
        if len(self.order) < FEWEST:
            return 1.0
        return min(1.0, self._looks * float((1 + gain / self._freedom) ** (-self._freedom / 2)))

    def _ringing(self, tau: float, omega: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the harmonics of a damped sine and cosine that repeat every load turn, (m,) each."""
        around = tau + 2j * np.pi * self.order / self.period
        size = 1 / (self.period * (around**2 + omega**2))
        return size * omega, size * around

    def _gains(self, tau: float, omega: float, places: int, shifts: list[int]) -> Floats:
        """Return the gains, (shifts, places), of all onsets and of delays by whole numbers of places."""
        number = self.order.astype(int)
        projected = []
        waves = self._ringing(tau, omega)
        for wave in waves:
            spectrum = np.zeros(places // 2 + 1, dtype=complex)
            spectrum[number] = self.weight / 2 * self.value * wave.conj()
            projected.append(np.fft.irfft(spectrum, places) * places)
        pairs = ((0, 0), (1, 1), (0, 1))
        products = [self.weight * (waves[i] * waves[j].conj()).real for i, j in pairs]
        gains = np.empty((len(shifts), places))
        for row, shift in enumerate(shifts):
            doubled = np.abs(1 - np.exp(-2j * np.pi * self.order * shift / places)) ** 2
            ss, cc, sc = (float(product @ doubled) for product in products)
            s, c = (wave - np.roll(wave, -shift) for wave in projected)
            gains[row] = (cc * s * s - 2 * sc * s * c + ss * c * c) / (ss * cc - sc * sc)
        return gains

    def _best(self, grid: list[tuple[float, float]], places: int, shifts: list[int]) -> Impacts:
        best = Impacts(0.0, *grid[0], 0.0, 0.5)
        for tau, omega in grid:
            gains = self._gains(tau, omega, places, shifts)
            row, onset = np.unravel_index(int(np.argmax(gains)), gains.shape)
            if gains[row, onset] > best.gain:
                best = Impacts(float(gains[row, onset]), tau, omega, onset / places, shifts[row] / places)
        return best

    @cached_property
    def _even(self) -> Impacts:
        """The best impacts half a turn apart."""
        if len(self.order) < FEWEST:
            return Impacts(0.0, *BENCH[1:3], 0.0, 0.5)
        return self._best([(tau, omega) for tau in TAUS for omega in OMEGAS], self._places, [self._places // 2])

    @cached_property
    def _free(self) -> Impacts:
        """The best impacts with T_d free."""
        if len(self.order) < FEWEST:
            return self._even
        places = self._places
        shifts = list(range(math.ceil(SHORTEST * places), places // 2 + 1))
        coarse = self._best([(tau, omega) for tau in TAUS[::2] for omega in OMEGAS[::2]], places, shifts)
        middle = round(coarse.delay * places) * FINER
        near = [shift for shift in range(middle - FINER, middle + FINER + 1) if shift <= places * FINER // 2]
        around = [(tau, coarse.omega + 2 * math.pi * step) for tau in TAUS for step in (-1, 0, 1)]
        return self._best(around, places * FINER, near)


def fold(recording: Recording, period: float) -> LoadTurn:
    """Return the harmonics of a load turn of ``period`` s, of a recording of two load turns or more."""
    turns = int(recording.duration / period + 1e-6)
    samples = max(round(period / recording.dt), 2)
    time = recording.start + period / samples * np.arange(turns * samples)
    speed = np.interp(time, recording.time, recording.speed)
    spectrum = np.fft.rfft(speed - speed.mean()) / len(speed)
    order = np.arange(2, min(int(BAND * period), samples // 2 - 1) + 1)
    reach = min(BESIDE, turns - 1)
    beside = np.abs(spectrum[np.add.outer(turns * order, [*range(-reach, 0), *range(1, reach + 1)])]) ** 2
    ripple = 2 * float(np.abs(spectrum[turns]))
    return LoadTurn(period, turns, order.astype(float), spectrum[turns * order], beside.mean(axis=1), ripple)


@dataclass(frozen=True, eq=False)
class Halves:
    """The two parts of each load turn, from shortly before an impact on, cut to the length of the shorter one.

    Joined, they have their impacts evenly apart, as the signature has them.

    Attributes:
        joined: the recording of the parts one after the other, from the start of the first part on.
        starts: (m,) where each part starts in the recording, s, those of parts beyond its end included.
        length: the length of each part, s.
    """

    joined: Recording
    starts: Floats
    length: float

    def onsets(self, t0: float) -> Floats:
        """Return the starts in the recording, s, of all oscillations of a train that starts at ``t0`` in the parts."""
        number = int((t0 - self.joined.start) / self.length + 1e-9)
        return self.starts[number:] + (t0 - self.joined.start - number * self.length)

    def model(self, time: Floats, x: Floats) -> Floats:
        """Return the signature of a (7,) fit to the joined parts at (N,) times of the recording, in its unit."""
        h = np.full_like(time, x[V_T])
        for number, t0 in enumerate(self.onsets(float(x[T0]))):
            h += (-1.0) ** number * oscillation(time - t0, x)
        return h


def halves(recording: Recording, turn: LoadTurn) -> Halves:
    """Return the two parts of each load turn of a recording with impacts T_d apart."""
    delay, end = turn.impacts.delay * turn.period, recording.start + recording.duration
    length = min(delay, turn.period - delay)
    first = recording.start + (turn.impacts.onset * turn.period - BEFORE * length) % turn.period - turn.period
    starts = np.sort(np.concatenate([first + late + turn.period * np.arange(turn.turns + 3) for late in (0.0, delay)]))
    starts = starts[starts >= recording.start]
    samples = max(round(length / recording.dt), 2)
    inside = starts[starts + length <= end + 1e-9]
    time = np.add.outer(inside, length / samples * np.arange(samples)).ravel()
    speed = np.interp(time, recording.time, recording.speed)
    return Halves(replace(recording, start=float(inside[0]), dt=length / samples, speed=speed), starts, length)
