"""Make noisy recordings of the simulated datasets, as in the thesis's test of noise sensitivity (section 7.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.errors import BenchError
from bench.numbers import require_whole
from problems.backlash.joint import Joint
from problems.backlash.levels import LEVELS
from problems.backlash.recordings import Recording
from problems.backlash.signature.datasets import dataset

NOISES = ("low", "high")
"""The levels of noise of section 7.3."""

FIRST_SAMPLES = 100
"""The number of first samples at which a recording may start (section 7.3)."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Noisy(Recording):
    """A noisy recording that begins at 0 s, with the true values.

    Attributes:
        peak: expected amplitude in rps: the positive peak of the undecimated disturbance, 0 without backlash.
        half_gap: delta in rad; None without backlash, for noise alone.
        cut: the number of samples of the dataset before the first sample.
    """

    peak: float
    half_gap: float | None
    cut: int


def peak_to_peak(level: int, noise: str = "low") -> float:
    """Return the peak-to-peak value in rps of the noise on a dataset 1 … 20; 0 has the noise of dataset 1.

    Eq. 7.2 with the range of the authors' published recordings: 0.2 to 0.5 rps, and 1.5 times that at the high level.
    Table 7.3 lists half of the peak-to-peak value.
    """
    return (0.2 + 0.3 * (max(level, 1) - 1) / 19) * (1.5 if noise == "high" else 1.0)


def noisy(level: int, noise: str = "low", draw: int = 0) -> Noisy:
    """Return a dataset with uniform white noise (eqs. 7.1 and 7.2), cut at a random one of its first 100 samples.

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
    clean = dataset(level or LEVELS[0])  # without backlash only its length is used
    speed = clean.speed if level else np.full_like(clean.speed, Joint().nominal_speed)
    cut = int(rng.integers(FIRST_SAMPLES))
    added = peak_to_peak(level, noise) * (rng.random(len(speed)) - 0.5)
    return Noisy(
        start=0.0,
        dt=float(clean.time[1] - clean.time[0]),
        speed=(speed + added)[cut:],
        peak=clean.peak if level else 0.0,
        half_gap=clean.half_gap if level else None,
        cut=cut,
    )
