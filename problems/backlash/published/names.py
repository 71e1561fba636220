"""The names of the published recordings as problems, and the files that hold them."""

from __future__ import annotations

import re

from bench.errors import BenchError
from problems.backlash.levels import LEVELS

CLEAN = range(3, 14)
"""The datasets of which the authors published the recordings without noise."""

ZIPS = {"low": range(1, 6), "high": range(11, 21)}
"""The numbers of the zips of noisy recordings, twenty datasets each. Low 3 and high 16 and 17 hold the same noise."""


def place(name: str) -> tuple[str, str, int]:
    """Return the file of a problem's name, the member of the file where it is a zip (else ""), and the dataset.

    Raises:
        BenchError: for a name that no published recording has.
    """
    if (match := re.fullmatch(r"published-(\d\d)", name)) and int(match[1]) in CLEAN:
        return f"Speeddata{int(match[1])}.xlsx", "", int(match[1])
    if match := re.fullmatch(r"published:(low|high)-(\d{1,2})-(\d{1,2})", name):
        noise, number, level = match[1], int(match[2]), int(match[3])
        if number in ZIPS[noise] and level in LEVELS:
            return f"Data_with_Noise_{number}.zip", f"SpeeddataNoise{level}.xlsx", level
    raise BenchError(
        f"there is no published recording {name!r}; there are published-03 to published-13, and with noise "
        "published:low-Z-K of zip Z = 1 … 5 and published:high-Z-K of zip Z = 11 … 20, dataset K = 1 … 20"
    )
