"""The problem families ``signature-01`` … ``signature-20``, ``noisy-00`` … ``noisy-20`` and ``recording:<path>``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.errors import BenchError, nearest
from problems.backlash.levels import LEVELS

if TYPE_CHECKING:
    from problems.backlash.signature.problem import SignatureFit

# The compiler is imported where a problem is loaded: every study asks every family for its names.

OPTIONS = ("period", "turns", "single", "unit", "amplitude_factor")


class _Simulated:
    """The family of the simulated datasets 1 … 20 of section 7.2.1."""

    def names(self) -> list[str]:
        return [f"signature-{level:02d}" for level in LEVELS]

    def load(self, name: str, /, **options: Any) -> SignatureFit:
        check_options(name, options)
        _check_name(name, self.names())
        from problems.backlash.recordings import Recording
        from problems.backlash.signature.datasets import dataset
        from problems.backlash.signature.problem import SignatureFit

        made = dataset(self.names().index(name) + 1)
        recording = Recording(float(made.time[0]), float(made.time[1] - made.time[0]), made.speed)
        return SignatureFit(name, recording, peak=made.peak, half_gap=made.half_gap, **options)


class _Recorded:
    """The family of a user's own recordings, one a path."""

    def names(self) -> list[str]:
        return []

    def load(self, name: str, /, **options: Any) -> SignatureFit:
        check_options(name, options)
        from problems.backlash.recordings.reader import read
        from problems.backlash.signature.problem import SignatureFit

        path = name.partition(":")[2]
        if not path:
            raise BenchError("a recording needs a path, as in recording:joint2.csv")
        return SignatureFit(name, read(Path(path)), **options)


class _Noisy:
    """The family of the simulated datasets with noise and a random start of section 7.3; 00 has no backlash."""

    def names(self) -> list[str]:
        return [f"noisy-{level:02d}" for level in (0, *LEVELS)]

    def load(self, name: str, /, *, noise: str = "low", draw: int = 0, **options: Any) -> SignatureFit:
        check_options(name, options, (*OPTIONS, "noise", "draw"))
        _check_name(name, self.names())
        from problems.backlash.signature.noise import noisy
        from problems.backlash.signature.problem import SignatureFit

        made = noisy(self.names().index(name), noise, draw)
        return SignatureFit(name, made, peak=made.peak, half_gap=made.half_gap, **options)


def check_options(name: str, options: dict[str, Any], known: tuple[str, ...] = OPTIONS) -> None:
    """Raise BenchError for an option that the problem does not have."""
    for option in options:
        if option not in known:
            raise BenchError(f"problem {name!r} has no option {option!r}{nearest(option, known)}")


def _check_name(name: str, known: list[str]) -> None:
    if name not in known:
        raise BenchError(f"unknown problem {name!r}{nearest(name, known)}")


signature = _Simulated()
recording = _Recorded()
noisy = _Noisy()
