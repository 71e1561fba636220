"""A recording of motor speed over time, and its reader: motor speed or position, as csv, text, xlsx or parquet.

>>> read("joint2.csv")                                    # time and speed by their headings, or the first two columns
>>> read("log.csv", time="Time_ms", position="enc_deg")   # a motor position, which is differentiated
>>> read("enc.csv", counts_per_rev=4096)                  # likewise, in counts of the motor's encoder
>>> read("speed.txt", speed=1, unit="rpm", rate=500)      # no column of time
"""

from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

import numpy as np

from bench.errors import BenchError, nearest
from bench.numbers import require_positive
from bench.typing import Floats
from problems.backlash.recordings.tables import UNITS, Table, load, parse_heading

Column = str | int
MOST_REPEATED = 0.01
"""The largest share of samples whose time stamp is that of the sample before."""
RATE_ADVICE = "give the sampling rate (--rate) where only the time stamps are wrong"


@dataclass(frozen=True, eq=False)
class Recording:
    """A uniformly sampled motor speed.

    A motor that turns backwards has a negative speed. Its sign is kept: the disturbance is then the mirror image, whose
    signature has the opposite A; the backlash follows from |A|.

    Attributes:
        start: time of the first sample, s.
        dt: sampling period, s.
        speed: (N,) motor speed, rps.
        unit: the unit of the values in the file; ``speed`` is in rps in any case.
        peak: the true amplitude in rps, the positive peak of the undecimated disturbance, where it is known.
        half_gap: the true delta in rad, where it is known.
        assumed: what its reader assumed of columns and units without a heading that says so, "" for nothing.
    """

    start: float
    dt: float
    speed: Floats
    unit: str = "rps"
    peak: float | None = None
    half_gap: float | None = None
    assumed: str = ""

    @property
    def time(self) -> Floats:
        """(N,) s: the uniform grid."""
        return np.linspace(self.start, self.start + self.dt * (len(self.speed) - 1), len(self.speed))

    @property
    def duration(self) -> float:
        """The time from the first sample to the last, s."""
        return self.dt * (len(self.speed) - 1)

    def window(self, begin: float | None = None, end: float | None = None) -> "Recording":
        """Return the samples at begin <= t <= end, in the recording's own time, s; None leaves that end open.

        Raises:
            BenchError: for a window that ends before it begins, or holds fewer than three samples.
        """
        count = len(self.speed)
        near = 1e-6  # of a sample: a limit at a sample's time includes the sample despite rounding
        first = 0 if begin is None else max(0, int(np.ceil((begin - self.start) / self.dt - near)))
        last = count - 1 if end is None else min(count - 1, int(np.floor((end - self.start) / self.dt + near)))
        if last - first < 2:
            whole = f"the recording lasts from {self.start:.6g} to {self.start + self.duration:.6g} s"
            raise BenchError(
                f"the window {spell(begin, end)} holds {max(0, last - first + 1)} samples, which is too few; {whole}"
            )
        return replace(self, start=self.start + first * self.dt, speed=self.speed[first : last + 1])


def read(
    path: str | Path,
    *,
    time: Column | None = None,
    speed: Column | None = None,
    position: Column | None = None,
    unit: str | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    counts_per_rev: float | None = None,
) -> Recording:
    """Return the recording that a file holds.

    A column is given by its heading, without regard to case and with or without its unit, or by its number from 1.
    Columns that are not given are recognised by their headings, in several languages; where that fails, the first
    column is the time and the next one the speed. Units are those given, else those of the headings (``speed_rpm``,
    ``speed [rpm]``, ``v (rad/s)``), else s and rps; a position's unit must be given in one of the two ways.

    A position is the angle of the motor, not that of the load. A position that jumps by a turn within a single turn's
    range is unwrapped; this needs more than two samples a turn. The speed is the difference of successive samples over
    the sampling period, as in a drive, at the middle of the two (section 8.2): the recording has one sample less and
    begins half a sampling period later.

    Successive samples with one time stamp become one sample, the mean of their values, which ``assumed`` says; they may
    be 1% of all samples.

    Args:
        path: a .csv, .txt, .xlsx or .parquet file.
        time: the column of time.
        speed: the column of motor speed.
        position: the column of motor position, instead of speed.
        unit: "rps", "rpm", "rad/s", "deg/s" of a speed; "rev", "rad", "deg", "counts" of a position.
        time_unit: "s", "ms", "us".
        rate: the sampling rate in Hz, instead of a column of time; the recording then starts at 0 s.
        counts_per_rev: the counts of the motor's encoder a turn, of a position in counts, which continue beyond a turn:
            of an encoder with quadrature, four times its lines.

    Raises:
        BenchError: for a file that cannot be read, columns that are missing or ambiguous, values that are not numbers,
            a position in counts without their number a turn, or a time that runs backwards or in unequal steps.
    """
    path = Path(path)
    either = UNITS["speed"] | UNITS["position"]
    for option, value, units in (("unit", unit, either), ("time_unit", time_unit, UNITS["time"])):
        if value is not None and value not in units:
            raise BenchError(f"recording {path}: {option} {value!r} is not known; give {', '.join(units)}")
    if rate is not None:
        require_positive(f"recording {path}: rate", rate, unit="Hz")
        if time is not None or time_unit is not None:
            raise BenchError(f"recording {path}: give either a column of time or a rate, not both")
    if counts_per_rev is not None:
        require_positive(f"recording {path}: counts_per_rev", counts_per_rev)
        if unit not in (None, "counts"):
            raise BenchError(f"recording {path}: counts_per_rev is for a position in counts, not in {unit}")
        unit = "counts"
    if speed is not None and position is not None:
        raise BenchError(f"recording {path}: give either a column of speed or one of position, not both")
    table = load(path)
    if not len(table.lines):
        raise BenchError(
            f"recording {path} has no line of numbers; it needs one for each sample, with the time and the motor's "
            "speed or position"
        )
    columns = _Columns(path, table)
    if rate is None and len(table.names) < 2:
        raise BenchError(
            f"recording {path} has no two columns, of time and of speed; where its one column is the speed, give the "
            "sampling rate (--rate)"
        )
    at = None if rate is not None else columns.find("time", time)
    role = "position" if position is not None or (counts_per_rev is not None and speed is None) else "speed"
    of = columns.find(role, position if position is not None else speed)
    if of is None and (other := columns.find("position", None)) is not None:
        role, of = "position", other
    if at is None and rate is None:
        at = 0 if of != 0 else 1
    if of is None:
        clock = at if at is not None else columns.find("time", None)
        of = next((i for i in range(len(table.names)) if i != clock), None)
    if of in (at, None):
        raise BenchError(f"recording {path}: column {table.names[at or 0]!r} cannot be both time and {role}")

    if len(table.lines) < 3:
        raise BenchError(f"recording {path} has too few samples for a load turn: {len(table.lines)}")
    of_unit = columns.unit(of, role, unit)
    scale = counts_per_rev if of_unit == "counts" else UNITS[role][of_unit]
    if scale is None:
        raise BenchError(
            f"recording {path}: column {table.names[of]!r} is in counts of an encoder; give the counts of a motor turn "
            "(--counts-per-rev)"
        )
    values = table.numbers(of) / scale
    if at is None:
        seconds = np.arange(len(values)) / float(rate or 1.0)
    else:
        seconds = table.numbers(at) / UNITS["time"][columns.unit(at, "time", time_unit)]
    bad = ~(np.isfinite(values) & np.isfinite(seconds))
    if bad.any():
        what = role if at is None else f"time or {role}"
        line = table.lines[int(np.argmax(bad))]
        raise BenchError(f"recording {path}: line {line} has no number in {what} (NaN or text); fix or cut it")
    seconds, values, repeated = _merged(seconds, values)
    start, dt = _grid(seconds, path)
    assumed = "; ".join(filter(None, (columns.assumed({"time": (at, time_unit), role: (of, unit)}), repeated)))
    if role == "speed":
        return Recording(start, dt, values, of_unit, assumed=assumed)
    return Recording(start + dt / 2, dt, _derivative(values, dt), of_unit, assumed=assumed)


class _Columns:
    """Find a table's columns and their units by the headings."""

    def __init__(self, path: Path, table: Table) -> None:
        self._path = path
        self._names = table.names
        self._headings = [parse_heading(name) for name in table.names]

    def find(self, role: str, wanted: Column | None) -> int | None:
        """Return the index of the wanted column, or else of the column recognised as the role's, or None."""
        if wanted is not None:
            return self._named(str(wanted).strip())
        columns = [i for i, heading in enumerate(self._headings) if heading.role == role]
        columns.sort(key=lambda i: self._headings[i].rank)
        if len(columns) > 1 and self._headings[columns[0]].rank == self._headings[columns[1]].rank:
            names = " or ".join(repr(self._names[i]) for i in columns[:2])
            raise BenchError(f"recording {self._path}: the {role} may be {names}; say which column it is")
        return columns[0] if columns else None

    def _named(self, wanted: str) -> int:
        for spelled in ([name.lower() for name in self._names], [heading.plain for heading in self._headings]):
            if spelled.count(wanted.lower()) == 1:
                return spelled.index(wanted.lower())
        if wanted.isdecimal() and 1 <= int(wanted) <= len(self._names):
            return int(wanted) - 1
        hint = nearest(wanted, self._names) if not wanted.isdecimal() else ""
        listed = "" if "known:" in hint else f"; its columns are {', '.join(self._names)}"
        raise BenchError(f"recording {self._path} has no column {wanted!r}{hint}{listed}")

    def unit(self, column: int, role: str, asked: str | None) -> str:
        """Return the unit of a column: the given unit, else that of its heading, else s or rps."""
        units, heading, name = UNITS[role], self._headings[column], self._names[column]
        if asked is not None:
            if asked not in units:
                raise BenchError(
                    f"recording {self._path}: {asked!r} is no unit of a {role}, which column {name!r} is; "
                    f"give {' or '.join(units)}"
                )
            return asked
        if heading.unit in units:
            return str(heading.unit)
        if heading.unknown or role == "position":
            which = f"unit {heading.unknown!r} of" if heading.unknown else "unit of the position in"
            raise BenchError(
                f"recording {self._path}: the {which} column {name!r} is not known; give it: {', '.join(units)}"
            )
        return next(iter(units))

    def assumed(self, used: dict[str, tuple[int | None, str | None]]) -> str:
        """Return a sentence on the columns whose role or unit no heading says, by role their index and given unit."""
        assumptions = []
        for role, (column, asked) in used.items():
            if column is None or asked is not None or self._headings[column].unit in UNITS[role]:
                continue
            assumptions.append(f"column {self._names[column]!r} for the {role} in {self.unit(column, role, asked)}")
        options = "--time, --speed, --time-unit and --unit"
        return (
            f"without a heading with a unit, the reader took {' and '.join(assumptions)}; {options} change it"
            if assumptions
            else ""
        )


def _merged(time: Floats, values: Floats) -> tuple[Floats, Floats, str]:
    """Return time and values with one sample for each run of equal time stamps, their mean, and a sentence on it.

    They are returned as they are where no time stamp is repeated, or more than ``MOST_REPEATED`` of them.
    """
    first = np.diff(time, prepend=-np.inf) != 0
    repeated = int((~first).sum())
    if not 0 < repeated <= MOST_REPEATED * len(time):
        return time, values, ""
    run = np.cumsum(first) - 1
    means = np.bincount(run, values) / np.bincount(run)
    stamps = "1 time stamp is" if repeated == 1 else f"{repeated} time stamps are"
    return time[first], means, f"{stamps} repeated, and samples of one time stamp were averaged"


def _grid(time: Floats, path: Path) -> tuple[float, float]:
    """Return the start and the step of a time that is uniform, s."""
    steps = np.diff(time)
    if (steps <= 0).any():
        sample = int(np.argmax(steps <= 0)) + 2
        raise BenchError(
            f"recording {path}: time stands still or runs backwards at sample {sample}; sort or fix it, or "
            f"{RATE_ADVICE}"
        )
    dt = float((time[-1] - time[0]) / (len(time) - 1))
    # One missing sample shifts half of the samples by more than this limit.
    off = np.abs(time - (time[0] + dt * np.arange(len(time)))) > 0.25 * dt
    if off.any():
        near = int(np.argmax(np.abs(steps - dt))) + 1
        raise BenchError(
            f"recording {path}: time is not uniform near sample {near + 1}, at {time[near]:.6g} s (steps of "
            f"{steps.min():.6g} to {steps.max():.6g} s); resample it to equal steps, cut out a part without "
            f"a gap, or {RATE_ADVICE}"
        )
    return float(time[0]), dt


def _derivative(turns: Floats, dt: float) -> Floats:
    """Return the (N - 1,) speed in rps midway between the (N,) positions in turns."""
    steps = np.diff(turns)
    if np.ptp(turns) <= 1.0 + 1e-6:  # a position that exceeds one turn has steps of any length
        steps -= np.round(steps)
    return steps / dt


def parse_window(text: str) -> tuple[float | None, float | None]:
    """Return the ends of a window given as ``"18.99:20.11"``, ``"18.99:"`` or ``":20.11"``, s.

    Raises:
        BenchError: for any other text, and for an end that is not after the beginning.
    """
    try:
        begin, end = (float(part) if part.strip() else None for part in text.split(":"))
        if not all(isfinite(value) for value in (begin, end) if value is not None):
            raise ValueError(text)
    except ValueError:
        message = f"{text!r} is not a window; give it in s as begin:end, such as 18.99:20.11, 2: or :10"
        raise BenchError(message) from None
    if begin is not None and end is not None and end <= begin:
        raise BenchError(f"the window {text!r} must end after it begins; give it in s as begin:end")
    return begin, end


def spell(begin: float | None, end: float | None) -> str:
    """Return a window as text, such as ``18.99:20.11``, the format that `parse_window` reads."""
    return ":".join("" if value is None else f"{value:.6g}" for value in (begin, end))
