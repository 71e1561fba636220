"""Read the published recordings by the names of their problems."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import numpy as np

from problems.backlash.joint import half_gap
from problems.backlash.published.download import require
from problems.backlash.published.names import place
from problems.backlash.published.table_7_3 import TABLE_7_3
from problems.backlash.recordings import Recording
from problems.backlash.recordings.tables import xlsx_rows


@dataclass(frozen=True, eq=False)
class Published:
    """A published recording and its true values, as far as they are known.

    Attributes:
        recording: the signal, 2401 samples at 500 Hz.
        peak: the "theoretical A" of Table 7.3 in rps, None for the datasets that are not in the table.
        half_gap: delta in rad.
    """

    recording: Recording
    peak: float | None
    half_gap: float


def published(name: str) -> Published:
    """Return the recording ``"published-12"``, or a noisy one: ``"published:low-1-12"`` is dataset 12 in zip 1.

    Raises:
        BenchError: for an unknown name, and for a file that is missing or not the published one.
    """
    file, member, level = place(name)
    row = TABLE_7_3.get(level)
    return Published(_read(require(file), member), row.theoretical if row else None, half_gap(level))


def _read(path: Path, member: str) -> Recording:
    """Return the recording of a published file, read like the authors' notebook reads it.

    The first row is always skipped: in the noisy dataset 1 it holds a sample, a second one at 0 s.
    """
    content = path.read_bytes() if not member else ZipFile(path).read(member)
    time, speed = np.array(xlsx_rows(BytesIO(content))[1:], dtype=np.float64).T
    return Recording(float(time[0]), float(time[-1] - time[0]) / (len(time) - 1), np.ascontiguousarray(speed))
