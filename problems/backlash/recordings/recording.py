"""A recording of motor speed over time, and the windows in which recordings are read."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError

Window = tuple[float | None, float | None]


@dataclass(frozen=True, eq=False)
class Recording:
    """A uniformly sampled motor speed.

    A motor that turns backwards has a negative speed. Its sign is kept: the disturbance is then the mirror image, whose
    signature has the opposite A; the backlash follows from |A|.

    Attributes:
        start: time of the first sample, s.
        dt: sampling period, s.
        speed: (N,) motor speed, rps.
        unit: the unit of the values in the file; ``speed`` is in rps in any case.
        peak: the true amplitude in rps, the positive peak of the undecimated disturbance, where it is known.
        half_gap: the true delta in rad, where it is known.
        assumed: what its reader assumed of columns and units without a heading, and what it mended, "" for nothing.
    """

    start: float
    dt: float
    speed: Floats
    unit: str = "rps"
    peak: float | None = None
    half_gap: float | None = None
    assumed: str = ""

    @property
    def time(self) -> Floats:
        """(N,) s: the uniform grid."""
        return np.linspace(self.start, self.start + self.dt * (len(self.speed) - 1), len(self.speed))

    @property
    def duration(self) -> float:
        """The time from the first sample to the last, s."""
        return self.dt * (len(self.speed) - 1)


def parse_window(text: str) -> Window:
    """Return the ends of a window given as ``"18.99:20.11"``, ``"18.99:"`` or ``":20.11"``, s.

    Raises:
        BenchError: for any other text, and for an end that is not after the beginning.
    """
    try:
        begin, end = (float(part) if part.strip() else None for part in text.split(":"))
        if not all(isfinite(value) for value in (begin, end) if value is not None):
            raise ValueError(text)
    except ValueError:
        message = f"{text!r} is not a window; give it in s as begin:end, such as 18.99:20.11, 2: or :10"
        raise BenchError(message) from None
    if begin is not None and end is not None and end <= begin:
        raise BenchError(f"the window {text!r} must end after it begins; give it in s as begin:end")
    return begin, end


def spell(begin: float | None, end: float | None) -> str:
    """Return a window as text, such as ``18.99:20.11``, the format that `parse_window` reads."""
    return ":".join("" if value is None else f"{value:.6g}" for value in (begin, end))


def too_few(window: Window, samples: int, start: float, end: float) -> BenchError:
    """Return the error on a window that holds too few samples of a recording from one time (s) to another."""
    return BenchError(
        f"the window {spell(*window)} holds {samples} samples, which is too few; the recording lasts from {start:.6g} "
        f"to {end:.6g} s"
    )
