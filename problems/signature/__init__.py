"""The constrained backlash-signature fit: ``signature-01`` … ``signature-20`` and ``recording:<path>``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.errors import BenchError, nearest

if TYPE_CHECKING:
    from problems.signature.problem import SignatureFit

# Compilers and interpolation are imported where a problem is loaded: every study asks every family for its names.

LEVELS = range(1, 21)
"""The simulated datasets of section 7.2.1, by the level of their backlash."""

OPTIONS = ("period", "turns", "unit", "amplitude_factor")


class _Simulated:
    """The family of the simulated datasets 1 … 20 of section 7.2.1."""

    def names(self) -> list[str]:
        return [f"signature-{level:02d}" for level in LEVELS]

    def load(self, name: str, /, **options: Any) -> SignatureFit:
        _check_names(name, options)
        if name not in self.names():
            raise BenchError(f"unknown problem {name!r}{nearest(name, self.names())}")
        from problems.signature.datasets import dataset
        from problems.signature.problem import SignatureFit
        from problems.signature.recordings import Recording

        made = dataset(self.names().index(name) + 1)
        recording = Recording(float(made.time[0]), float(made.time[1] - made.time[0]), made.speed)
        return SignatureFit(name, recording, peak=made.peak, half_gap=made.half_gap, **options)


class _Recorded:
    """The family of a user's own recordings, one a path."""

    def names(self) -> list[str]:
        return []

    def load(self, name: str, /, **options: Any) -> SignatureFit:
        _check_names(name, options)
        from problems.signature.problem import SignatureFit
        from problems.signature.recordings import read

        path = name.partition(":")[2]
        if not path:
            raise BenchError("a recording needs a path, as in recording:joint2.csv")
        return SignatureFit(name, read(Path(path)), **options)


def _check_names(name: str, options: dict[str, Any]) -> None:
    for option in options:
        if option not in OPTIONS:
            raise BenchError(f"problem {name!r} has no option {option!r}{nearest(option, OPTIONS)}")


signature = _Simulated()
recording = _Recorded()
