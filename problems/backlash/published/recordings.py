"""Read the published recordings, and the thesis's Table 7.3, the test on noisy signals."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import ZipFile

import numpy as np

from problems.backlash.joint import half_gap
from problems.backlash.published.download import require
from problems.backlash.recordings import Recording
from problems.backlash.recordings.tables import first_sheet

if TYPE_CHECKING:
    import pandas as pd


@cache
def table_7_3() -> pd.DataFrame:
    """Return Table 7.3 of Giovannitti, "Virtual measurement of backlash in industrial manipulators", by dataset.

    Dataset 0 is noise without backlash. The table names no datasets; its theoretical values are those of 2 to 11. It is
    of 30 runs of CMA-ES on one noisy dataset each, in rps: ``theoretical``, the positive peak of the undecimated
    disturbance, which is the expected A; ``noise``, half of its peak-to-peak value; ``mean`` and ``stdev`` of the A of
    the runs; and ``error``, |mean - theoretical| / theoretical in percent, NaN without backlash.
    """
    import pandas as pd

    return pd.read_csv(Path(__file__).with_name("table_7_3.csv"), index_col="dataset")


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
    peak = table_7_3()["theoretical"].get(level)
    return Recording(start, dt, np.ascontiguousarray(speed), peak=peak, half_gap=half_gap(level))
