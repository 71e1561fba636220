"""Read a user's recording: two columns, time in s and motor speed in rps, as csv or xlsx."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.errors import BenchError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Recording:
    """A uniformly sampled signal.

    Attributes:
        start: time of the first sample, s.
        dt: sampling period, s.
        speed: (N,) motor speed, rps.
    """

    start: float
    dt: float
    speed: Floats

    @property
    def time(self) -> Floats:
        """(N,) s: the uniform grid."""
        return np.linspace(self.start, self.start + self.dt * (len(self.speed) - 1), len(self.speed))


def read(path: str | Path) -> Recording:
    """Return the recording of a csv or xlsx file, whose first two columns are time and speed, headed or not.

    Raises:
        BenchError: for a file that cannot be read, has one column, values that are no numbers, or a time that runs
            backwards or in unequal steps.
    """
    path = Path(path)
    if path.suffix.lower() not in READERS:
        raise BenchError(f"recording {path}: unknown kind of file {path.suffix!r}; give a .csv or .xlsx file")
    try:
        table = READERS[path.suffix.lower()](path)
    except FileNotFoundError as error:
        raise BenchError(f"recording {path}: there is no such file") from error
    except Exception as error:  # the readers raise many kinds for a damaged file
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise BenchError(f"recording {path} cannot be read: {reason}") from error
    if table.shape[1] < 2:
        raise BenchError(f"recording {path} has {table.shape[1]} columns; it needs two, time in s and speed in rps")
    values = table.iloc[:, :2].apply(pd.to_numeric, errors="coerce")
    if len(values) and values.iloc[0].isna().all():  # the header line
        values = values.iloc[1:]
    if len(values) < 3:
        raise BenchError(f"recording {path} has {len(values)} samples; a load turn needs many more")
    bad = values.index[~np.isfinite(values.to_numpy(dtype=float)).all(axis=1)]
    if len(bad):
        line = int(bad[0]) + 1
        raise BenchError(f"recording {path}: line {line} has no number in time or speed (NaN or text); mend or cut it")
    return _uniform(values.iloc[:, 0].to_numpy(dtype=float), values.iloc[:, 1].to_numpy(dtype=float), path)


def _uniform(time: Floats, speed: Floats, path: Path) -> Recording:
    steps = np.diff(time)
    if (steps <= 0).any():
        line = int(np.argmax(steps <= 0)) + 2
        raise BenchError(f"recording {path}: time stands still or runs backwards at sample {line}; sort or mend it")
    dt = float((time[-1] - time[0]) / (len(time) - 1))
    off = np.abs(time - (time[0] + dt * np.arange(len(time)))) > 0.25 * dt  # a missing sample shifts half of them so
    if off.any():
        near = int(np.argmax(np.abs(steps - dt))) + 2
        raise BenchError(
            f"recording {path}: time is not uniform near sample {near} (steps of {steps.min():.6g} to "
            f"{steps.max():.6g} s); resample it to equal steps"
        )
    return Recording(float(time[0]), dt, speed)


def _read_csv(path: Path) -> pd.DataFrame:
    """Return the cells of a text file separated by semicolons, tabs, commas or blanks; decimal commas become points."""
    lines = {
        i: line for i, line in enumerate(path.read_text("utf-8-sig", errors="replace").splitlines()) if line.strip()
    }
    middle = list(lines.values())[len(lines) // 2] if lines else ""  # neither a header nor a closing remark
    separator = next((mark for mark in (";", "\t", ",") if mark in middle), None)
    cells = pd.DataFrame([line.split(separator) for line in lines.values()], index=list(lines))
    return cells.map(lambda cell: cell.replace(",", ".").strip(' "') if isinstance(cell, str) else cell)


def _read_xlsx(path: Path) -> pd.DataFrame:
    return pd.read_excel(path, header=None)


READERS = {".csv": _read_csv, ".txt": _read_csv, ".xlsx": _read_xlsx}
