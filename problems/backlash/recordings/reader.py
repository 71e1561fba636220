"""Read a user's recording: motor speed or motor position over time, as csv, text, xlsx or parquet.

>>> read("joint2.csv")                                    # time and speed by their headings, or the first two columns
>>> read("log.csv", time="Time_ms", position="enc_deg")   # a motor position, which is differentiated
>>> read("speed.txt", speed=1, unit="rpm", rate=500)      # no column of time
"""

from pathlib import Path

import numpy as np

from bench.errors import BenchError, nearest
from bench.numbers import require_positive
from bench.problem import Floats
from problems.backlash.recordings.recording import Recording
from problems.backlash.recordings.tables import Table, load
from problems.backlash.recordings.units import POSITION, SPEED, TIME, UNITS, Heading, parse_heading

Column = str | int


def read(
    path: str | Path,
    *,
    time: Column | None = None,
    speed: Column | None = None,
    position: Column | None = None,
    unit: str | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
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

    Args:
        path: a .csv, .txt, .xlsx or .parquet file.
        time: the column of time.
        speed: the column of motor speed.
        position: the column of motor position, instead of speed.
        unit: "rps", "rpm", "rad/s", "deg/s" of a speed; "rev", "rad", "deg" of a position.
        time_unit: "s", "ms", "us".
        rate: the sampling rate in Hz, instead of a column of time; the recording then starts at 0 s.

    Raises:
        BenchError: for a file that cannot be read, columns that are missing or ambiguous, values that are not numbers,
            or a time that runs backwards or in unequal steps.
    """
    path = Path(path)
    _check_options(path, time, speed, position, unit, time_unit, rate)
    table = load(path)
    columns = _Columns(path, table)
    if rate is None and len(table.names) < 2:
        raise BenchError(
            f"recording {path} has {len(table.names)} columns; it needs two, time in s and speed in rps, or else a rate"
        )
    at = None if rate is not None else columns.find("time", time)
    role = "position" if position is not None else "speed"
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
        raise BenchError(f"recording {path} has {len(table.lines)} samples; a load turn needs many more")
    of_unit = columns.unit(of, role, unit)
    values = table.numbers(of)
    if at is None:
        seconds = np.arange(len(values)) / float(rate or 1.0)
    else:
        seconds = table.numbers(at) / TIME[columns.unit(at, "time", time_unit)]
    bad = ~(np.isfinite(values) & np.isfinite(seconds))
    if bad.any():
        what = role if at is None else f"time or {role}"
        line = table.lines[int(np.argmax(bad))]
        raise BenchError(f"recording {path}: line {line} has no number in {what} (NaN or text); mend or cut it")
    start, dt = _grid(seconds, path)
    if role == "speed":
        return Recording(start, dt, values / SPEED[of_unit], of_unit)
    return Recording(start + dt / 2, dt, _derivative(values / POSITION[of_unit], dt), of_unit)


class _Columns:
    """Find a table's columns and their units by the headings."""

    def __init__(self, path: Path, table: Table) -> None:
        self._path = path
        self._names = table.names
        self._headings: list[Heading] = [parse_heading(name) for name in table.names]

    def find(self, role: str, wanted: Column | None) -> int | None:
        """Return the index of the wanted column, or else of the column recognised as the role's, or None."""
        if wanted is not None:
            return self._named(str(wanted).strip())
        known = [i for i, heading in enumerate(self._headings) if heading.role == role]
        known.sort(key=lambda i: self._headings[i].rank)
        if len(known) > 1 and self._headings[known[0]].rank == self._headings[known[1]].rank:
            names = " or ".join(repr(self._names[i]) for i in known[:2])
            raise BenchError(f"recording {self._path}: the {role} may be {names}; say which column it is")
        return known[0] if known else None

    def _named(self, wanted: str) -> int:
        for spelled in ([name.lower() for name in self._names], [heading.plain for heading in self._headings]):
            if spelled.count(wanted.lower()) == 1:
                return spelled.index(wanted.lower())
        if wanted.isdecimal() and 1 <= int(wanted) <= len(self._names):
            return int(wanted) - 1
        hint = nearest(wanted, self._names) if not wanted.isdecimal() else ""
        listed = "" if "known:" in hint else f"; its columns are {', '.join(self._names)}"
        raise BenchError(f"recording {self._path} has no column {wanted!r}{hint}{listed}")

    def unit(self, column: int, role: str, given: str | None) -> str:
        """Return the unit of a column: the given unit, else that of its heading, else s or rps."""
        known, heading, name = UNITS[role], self._headings[column], self._names[column]
        if given is not None:
            if given not in known:
                raise BenchError(
                    f"recording {self._path}: {given!r} is no unit of a {role}, which column {name!r} is; "
                    f"give {' or '.join(known)}"
                )
            return given
        if heading.unit in known:
            return str(heading.unit)
        if heading.unknown or role == "position":
            which = f"unit {heading.unknown!r} of" if heading.unknown else "unit of the position in"
            raise BenchError(
                f"recording {self._path}: the {which} column {name!r} is not known; give it: {', '.join(known)}"
            )
        return next(iter(known))


def _check_options(
    path: Path,
    time: Column | None,
    speed: Column | None,
    position: Column | None,
    unit: str | None,
    time_unit: str | None,
    rate: float | None,
) -> None:
    for option, value, units in (("unit", unit, {**SPEED, **POSITION}), ("time_unit", time_unit, TIME)):
        if value is not None and value not in units:
            raise BenchError(f"recording {path}: {option} {value!r} is not known; give {', '.join(units)}")
    if rate is not None:
        require_positive(f"recording {path}: rate", rate, unit="Hz")
    if rate is not None and (time is not None or time_unit is not None):
        raise BenchError(f"recording {path}: give either a column of time or a rate, not both")
    if speed is not None and position is not None:
        raise BenchError(f"recording {path}: give either a column of speed or one of position, not both")


def _grid(time: Floats, path: Path) -> tuple[float, float]:
    """Return the start and the step of a time that is uniform, s."""
    steps = np.diff(time)
    if (steps <= 0).any():
        sample = int(np.argmax(steps <= 0)) + 2
        raise BenchError(f"recording {path}: time stands still or runs backwards at sample {sample}; sort or mend it")
    dt = float((time[-1] - time[0]) / (len(time) - 1))
    # One missing sample shifts half of the samples by more than this limit.
    off = np.abs(time - (time[0] + dt * np.arange(len(time)))) > 0.25 * dt
    if off.any():
        near = int(np.argmax(np.abs(steps - dt))) + 1
        raise BenchError(
            f"recording {path}: time is not uniform near sample {near + 1}, at {time[near]:.6g} s (steps of "
            f"{steps.min():.6g} to {steps.max():.6g} s); resample it to equal steps, or cut out a part without a gap"
        )
    return float(time[0]), dt


def _derivative(turns: Floats, dt: float) -> Floats:
    """Return the (N - 1,) speed in rps midway between the (N,) positions in turns."""
    steps = np.diff(turns)
    if np.ptp(turns) <= 1.0 + 1e-6:  # a position that exceeds one turn has steps of any length
        steps -= np.round(steps)
    return steps / dt
