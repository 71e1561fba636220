"""The problem family of the authors' recordings: ``published-03`` … ``published-13`` and ``published:low-1-12``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from bench.helpers.errors import BenchError
from problems.backlash import LEVELS
from problems.backlash.signature.families import Family

if TYPE_CHECKING:
    from problems.backlash.recordings import Recording

CLEAN = range(3, 14)  # the datasets of which the authors published the recordings without noise
# The numbers of the zips of noisy recordings, twenty datasets each. Low 3 and high 16 and 17 hold the same noise.
ZIPS = {"low": range(1, 6), "high": range(11, 21)}


def _published(name: str) -> Recording:
    """Return the recording ``"published-12"``, or a noisy one: ``"published:low-1-12"`` is dataset 12 in zip 1."""
    clean = re.fullmatch(r"published-(\d\d)", name)
    noisy = re.fullmatch(r"published:(low|high)-(\d{1,2})-(\d{1,2})", name)
    if clean and (level := int(clean[1])) in CLEAN:
        file, member = f"Speeddata{level}.xlsx", ""
    elif noisy and (number := int(noisy[2])) in ZIPS[noisy[1]] and (level := int(noisy[3])) in LEVELS:
        file, member = f"Data_with_Noise_{number}.zip", f"SpeeddataNoise{level}.xlsx"
    else:
        raise BenchError(
            f"there is no published recording {name!r}; there are published-03 to published-13, and with noise "
            "published:low-Z-K of zip Z = 1 … 5 and published:high-Z-K of zip Z = 11 … 20, dataset K = 1 … 20"
        )
    from problems.backlash.published.recordings import read

    return read(file, member, level)


published = Family(tuple(f"published-{level:02d}" for level in CLEAN), _published)
