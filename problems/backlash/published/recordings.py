"""Read the published recordings by the names of their problems."""

from __future__ import annotations

import re
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pandas as pd

from bench.errors import BenchError
from problems.backlash.joint import half_gap
from problems.backlash.published.download import require
from problems.backlash.published.table_7_3 import TABLE_7_3
from problems.backlash.recordings import Recording
from problems.backlash.signature import CLEAN, LEVELS

ZIPS = {"low": range(1, 6), "high": range(11, 21)}
"""The numbers of the zips of noisy recordings, twenty datasets each. Low 3 and high 16 and 17 hold the same noise."""


@dataclass(frozen=True, eq=False)
class Published:
    """A published recording and what is known of the truth behind it.

    Attributes:
        recording: the signal, 2401 samples at 500 Hz.
        peak: the "theoretical A" of Table 7.3 in rps, None for the datasets that the table does not have.
        half_gap: delta in rad.
    """

    recording: Recording
    peak: float | None
    half_gap: float


def published(name: str) -> Published:
    """Return the recording ``"published-12"``, or a noisy one: ``"published:low-1-12"`` is dataset 12 in zip 1.

    Raises:
        BenchError: for a name that none has, and for a file that is missing or not the published one.
    """
    file, member, level = _place(name)
    row = TABLE_7_3.get(level)
    return Published(_read(require(file), member), row.theoretical if row else None, half_gap(level))


def _place(name: str) -> tuple[str, str, int]:
    """Return the file of a problem's name, the member where it is a zip, and the dataset."""
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


def _read(path: Path, member: str) -> Recording:
    """Return the recording of a file whose content is known, read as the authors' notebook does.

    Its first row is passed over whatever it holds: the noisy dataset 1 has a sample there, a second one at 0 s.
    """
    content = path.read_bytes() if not member else ZipFile(path).read(member)
    time, speed = pd.read_excel(BytesIO(content)).to_numpy(dtype=np.float64).T
    return Recording(float(time[0]), float(time[-1] - time[0]) / (len(time) - 1), np.ascontiguousarray(speed))
