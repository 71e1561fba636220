"""Read the published recordings, and the thesis's Table 7.3, the test on noisy signals."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import NamedTuple
from zipfile import ZipFile

import numpy as np

from problems.backlash.joint import half_gap
from problems.backlash.published.download import require
from problems.backlash.recordings import Recording
from problems.backlash.recordings.tables import first_sheet


class Row(NamedTuple):
    """A row of Table 7.3: 30 runs of CMA-ES on one noisy dataset, in rps.

    Attributes:
        theoretical: the positive peak of the undecimated disturbance, which is the expected A.
        noise: amplitude of the uniform noise, half of its peak-to-peak value.
        mean: mean of the A of the runs.
        stdev: their standard deviation.
        error: |mean - theoretical| / theoretical in percent, None without backlash.
    """

    theoretical: float
    noise: float
    mean: float
    stdev: float
    error: float | None


@cache
def table_7_3() -> dict[int, Row]:
    """Return Table 7.3 of Giovannitti, "Virtual measurement of backlash in industrial manipulators", by dataset.

    Dataset 0 is noise without backlash. The table names no datasets; its theoretical values are those of 2 to 11.
    """
    _, *rows = csv.reader(Path(__file__).with_name("table_7_3.csv").read_text(encoding="utf-8").splitlines())
    return {int(row[0]): Row._make(float(number) if number else None for number in row[1:]) for row in rows}


def read(file: str, member: str, level: int) -> Recording:
    """Return a published recording of 2401 samples at 500 Hz, read like the authors' notebook reads it.

    The first row is always skipped: in the noisy dataset 1 it holds a sample, a second one at 0 s. The recording's peak
    is the theoretical one of Table 7.3, None for the datasets that are not in the table.

    Args:
        file: the name of the published file.
        member: the workbook within it if it is a zip, else "".
        level: the dataset.

    Raises:
        BenchError: for a file that is missing or not the published one.
    """
    path = require(file)
    content = path.read_bytes() if not member else ZipFile(path).read(member)
    time, speed = first_sheet(content).iloc[1:].to_numpy(dtype=np.float64).T
    start, dt = float(time[0]), float(time[-1] - time[0]) / (len(time) - 1)
    peak = table_7_3()[level].theoretical if level in table_7_3() else None
    return Recording(start, dt, np.ascontiguousarray(speed), peak=peak, half_gap=half_gap(level))
