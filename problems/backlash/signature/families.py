"""The problem families ``signature-01`` …, ``noisy-00`` …, ``wrist-1-healthy`` … and ``recording:<path>``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from bench.helpers.errors import BenchError, nearest
from problems.backlash import LEVELS

if TYPE_CHECKING:
    from bench.contract.typing import Options
    from problems.backlash.recordings import Recording
    from problems.backlash.signature.problem import SignatureFit

# The compiler is imported where a problem is loaded: every study asks every family for its names.

OPTIONS = ("period", "turns", "single", "unit", "amplitude_factor", "t0_turns", "constrained")


@dataclass(frozen=True)
class Family:
    """A problem family of recordings, to which the signature is fitted.

    Attributes:
        listed: the names of the problems that can be listed.
        prefix: what other names begin with, "" for none.
        read: returns the recording of a problem's name.
        options: the options that ``read`` takes, besides those of the fit.
        fit: options of the fit that differ from the usual ones where a study gives none.
    """

    listed: tuple[str, ...]
    read: Callable[..., Recording]
    prefix: str = ""
    options: tuple[str, ...] = ()
    fit: Options = field(default_factory=dict)

    def names(self) -> list[str]:
        """Return the names of the problems that can be listed."""
        return list(self.listed)

    def load(self, name: str, /, **options: Any) -> SignatureFit:
        """Return the fit to the recording of that name; raises BenchError for an unknown name or option."""
        if name not in self.listed and not (self.prefix and name.startswith(self.prefix)):
            raise BenchError(f"unknown problem {name!r}{nearest(name, self.listed)}")
        allowed = (*OPTIONS, *self.options)
        for option in options:
            if option not in allowed:
                raise BenchError(f"problem {name!r} has no option {option!r}{nearest(option, allowed)}")
        recording = self.read(name, **{option: options.pop(option) for option in self.options if option in options})
        from problems.backlash.signature.problem import SignatureFit

        return SignatureFit(name, recording, **{**self.fit, **options})


def level(name: str) -> int:
    """Return the number at the end of a name."""
    return int(name.rpartition("-")[2])


def _dataset(name: str) -> Recording:
    from problems.backlash.signature import datasets

    return datasets.dataset(level(name))


def _noisy(name: str, **options: Any) -> Recording:
    from problems.backlash.signature import datasets

    return datasets.noisy(level(name), **options)


def _wrist(name: str, **options: Any) -> Recording:
    from problems.backlash.signature.wrist import recorded

    return recorded(name, **options)


def _recorded(name: str) -> Recording:
    path = name.partition(":")[2]
    if not path:
        raise BenchError("a recording needs a path, as in recording:joint2.csv")
    from problems.backlash.recordings import read

    return read(path)


signature = Family(tuple(f"signature-{level:02d}" for level in LEVELS), _dataset)
noisy = Family(tuple(f"noisy-{level:02d}" for level in (0, *LEVELS)), _noisy, options=("noise", "draw"))
wrist = Family(
    tuple(f"wrist-{joint}-{state}" for joint in (1, 4, 5, 6) for state in ("healthy", "tampered")), _wrist,
    options=("draw",), fit={"single": True, "period": 2.0},
)  # fmt: skip
recording = Family((), _recorded, "recording:")
