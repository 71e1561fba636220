"""From an amplitude to a backlash: the mapping delta = f(A) of section 4.4, made with the simulator."""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from problems.joint import half_gap
from problems.signature import LEVELS
from problems.signature.datasets import dataset, simulated

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Calibration:
    """A monotone curve through simulated pairs of amplitude and half-gap.

    A shape-preserving interpolation, not the cubic of eq. 4.7: that was fitted on small gaps and is 2.6e-4 rad off at
    the largest. The joint's own disturbance without backlash is its lower end.

    Attributes:
        amplitude: (m,) expected amplitudes in rpm, increasing.
        half_gap: (m,) rad, increasing from 0.
    """

    amplitude: Floats
    half_gap: Floats

    def backlash(self, amplitude: float) -> float:
        """Return the half-gap delta in rad of an amplitude in rpm; NaN outside the simulated range, never a guess."""
        return float(self._curve(abs(amplitude)))

    @cached_property
    def _curve(self) -> PchipInterpolator:
        return PchipInterpolator(self.amplitude, self.half_gap, extrapolate=False)


@cache
def default_calibration() -> Calibration:
    """Return the calibration of the default joint, from no gap past level 20, whose fits scatter to both sides."""
    beyond = (half_gap(LEVELS[-1]) + 0.0004 * step for step in range(1, 6))  # past 6e-3 rad the motion is irregular
    made = [simulated(0.0), *(dataset(level) for level in LEVELS), *(simulated(gap) for gap in beyond)]
    return Calibration(np.array([60 * each.peak for each in made]), np.array([each.half_gap for each in made]))
