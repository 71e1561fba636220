"""A recording of motor speed, and parts of one."""

from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from bench.errors import BenchError
from bench.problem import Floats


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
    """

    start: float
    dt: float
    speed: Floats
    unit: str = "rps"

    @property
    def time(self) -> Floats:
        """(N,) s: the uniform grid."""
        return np.linspace(self.start, self.start + self.dt * (len(self.speed) - 1), len(self.speed))

    @property
    def duration(self) -> float:
        """The time from the first sample to the last, s."""
        return self.dt * (len(self.speed) - 1)

    def window(self, begin: float | None = None, end: float | None = None) -> "Recording":
        """Return the samples at begin <= t <= end, in the recording's own time, s; None leaves that end open.

        Raises:
            BenchError: for a window that ends before it begins, or holds fewer than three samples.
        """
        count = len(self.speed)
        near = 1e-6  # of a sample: a limit at a sample's time includes the sample despite rounding
        first = 0 if begin is None else max(0, int(np.ceil((begin - self.start) / self.dt - near)))
        last = count - 1 if end is None else min(count - 1, int(np.floor((end - self.start) / self.dt + near)))
        if last - first < 2:
            whole = f"the recording lasts from {self.start:.6g} to {self.start + self.duration:.6g} s"
            raise BenchError(
                f"the window {spell(begin, end)} holds {max(0, last - first + 1)} samples, which is too few; {whole}"
            )
        return replace(self, start=self.start + first * self.dt, speed=self.speed[first : last + 1])


def parse_window(text: str) -> tuple[float | None, float | None]:
    """Return the ends of a window given as ``"18.99:20.11"``, ``"18.99:"`` or ``":20.11"``, s.

    Raises:
        BenchError: for any other text, and for an end that is not after the beginning.
    """
    first, colon, last = text.partition(":")
    try:
        begin, end = (float(part) if part.strip() else None for part in (first, last))
        known = bool(colon) and all(isfinite(value) for value in (begin, end) if value is not None)
    except ValueError:
        known = False
    if not known:
        raise BenchError(f"{text!r} is not a window; give it in s as begin:end, such as 18.99:20.11, 2: or :10")
    if begin is not None and end is not None and end <= begin:
        raise BenchError(f"the window {text!r} must end after it begins; give it in s as begin:end")
    return begin, end


def spell(begin: float | None, end: float | None) -> str:
    """Return a window as text, such as ``18.99:20.11``, the format that `parse_window` reads."""
    return ":".join("" if value is None else f"{value:.6g}" for value in (begin, end))
