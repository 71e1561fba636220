"""The problem family of the authors' recordings: ``published-03`` … ``published-13`` and ``published:low-1-12``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from bench.helpers.errors import BenchError
from problems.backlash import LEVELS
from problems.backlash.signature.families import Family, level

if TYPE_CHECKING:
    from problems.backlash.recordings import Recording

CLEAN = range(3, 14)  # the datasets of which the authors published the recordings without noise
# The numbers of the zips of noisy recordings, twenty datasets each. Low 3 and high 16 and 17 hold the same noise.
ZIPS = {"low": range(1, 6), "high": range(11, 21)}


def _published(name: str) -> Recording:
    """Return the recording ``"published-12"``, or a noisy one: ``"published:low-1-12"`` is dataset 12 in zip 1."""
    from problems.backlash.published.recordings import read

    if name in published.listed:
        return read(f"Speeddata{level(name)}.xlsx", "", level(name))
    noisy = re.fullmatch(r"published:(low|high)-(\d{1,2})-(\d{1,2})", name)
    if not noisy or int(noisy[2]) not in ZIPS[noisy[1]] or int(noisy[3]) not in LEVELS:
        raise BenchError(
            f"there is no published recording {name!r}; there are published-03 to published-13, and with noise "
            "published:low-Z-K of zip Z = 1 … 5 and published:high-Z-K of zip Z = 11 … 20, dataset K = 1 … 20"
        )
    return read(f"Data_with_Noise_{int(noisy[2])}.zip", f"SpeeddataNoise{int(noisy[3])}.xlsx", int(noisy[3]))


published = Family(tuple(f"published-{number:02d}" for number in CLEAN), _published, "published:")
