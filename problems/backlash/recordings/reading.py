"""Read a recording of motor speed or position from csv, text, xlsx or parquet, or those of several joints in one file.

>>> read("joint2.csv")                                    # time and speed by their headings, or the first two columns
>>> read("log.csv", speed="enc", unit="deg")              # a motor position, which is differentiated
>>> read_joints("cell.csv", joint_column="axis")          # the joint of each line stands in a column
>>> read_joints("cell.csv", joint_column="speed_*")       # each joint has a column of its own
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash.recordings.columns import Column, Columns
from problems.backlash.recordings.headings import UNITS
from problems.backlash.recordings.recording import Recording, Window, too_few
from problems.backlash.recordings.sampling import MOST_MISSING, merged, uniform, unwrapped
from problems.backlash.recordings.tables import Table, load


class NoRecordingError(BenchError):
    """A file is no recording at all: it has no samples, and no heading speaks of a time, a speed or a position."""


@dataclass(frozen=True)
class _Layout:
    """The place of the samples in a file: the arguments of :func:`read`."""

    path: Path
    speed: Column | None = None
    unit: str | None = None
    window: Window = (None, None)

    def __post_init__(self) -> None:
        units = UNITS["speed"] | UNITS["position"]
        if self.unit is not None and self.unit not in units:
            raise BenchError(f"recording {self.path}: unit {self.unit!r} is not known; give {', '.join(units)}")


def read(
    path: str | Path, *, speed: Column | None = None, unit: str | None = None, window: Window = (None, None)
) -> Recording:
    """Return the recording that a file holds.

    A column is given by its heading, without regard to case and with or without its unit, or by its number from 1.
    Columns that are not given are recognised by their headings, in several languages; where that fails, the first
    column is the time and the next one the speed. Units are those of the headings (``speed_rpm``, ``speed [rpm]``,
    ``v (rad/s)``), or for a speed or position the one given, else s and rps; a position's unit must be given in one of
    the two ways. A time may be a date and time; it then counts from the first sample.

    A position is the angle of the motor, not that of the load. A position that jumps by a turn within a single turn's
    range is continued; this needs more than two samples a jump. The speed
    is the difference of successive samples over the sampling period, as in a drive, at the middle of the two (section
    8.2): the recording has one sample less and begins half a sampling period later.

    Successive samples with one time stamp become one sample, the mean of their values; they may be 1% of all samples.
    Missing samples, up to 1%, and unequal steps are interpolated. ``Recording.assumed`` reports all of it.

    Args:
        path: a .csv, .txt, .xlsx or .parquet file.
        speed: the column of motor speed, or of its position where heading or unit say so.
        unit: "rps", "rpm", "rad/s", "deg/s" of a speed; "rev", "rad", "deg" of a position.
        window: the ends (s) of the part to read, each a number or None; what is outside may be damaged.

    Raises:
        BenchError: for a file that cannot be read, columns that are missing or ambiguous, values that are not numbers,
            or a time that runs backwards or has gaps; with the line and column. It is a :class:`NoRecordingError` where
            the file is something else altogether.
    """
    place = _Layout(Path(path), speed, unit, window)
    return _recording(load(place.path), place)


def read_joints(
    path: str | Path,
    *,
    joint_column: str | None = None,
    speed: Column | None = None,
    unit: str | None = None,
    window: Window = (None, None),
) -> list[tuple[str, Callable[[], Recording]]]:
    """Return the joints in a file by name, each with a function that returns its recording, as :func:`read` does.

    Args:
        path: as for :func:`read`.
        joint_column: the column that says which joint a line is of; or, with an ``*``, the headings of columns of a
            joint each, where the ``*`` stands for the joint's name; None where the file has one joint, "" by name.
        speed, unit, window: as for :func:`read`.

    Raises:
        BenchError: for a file that cannot be read, and for a column of joints that it does not have. The functions
            raise what :func:`read` does.
    """
    place = _Layout(Path(path), speed, unit, window)
    if joint_column is None:
        return [("", lambda: _recording(load(place.path), place))]
    table = load(place.path)
    columns = Columns(place.path, table.names)
    if "*" not in joint_column:
        parts = table.by(columns.named(joint_column))
        return [(_joint(name), partial(_recording, part, place)) for name, part in parts.items()]
    pattern = re.compile("(.*)".join(map(re.escape, joint_column.split("*"))), re.IGNORECASE)
    found = [(match, i) for i, name in enumerate(table.names) if (match := pattern.fullmatch(name))]
    if not found:
        raise BenchError(f"recording {path} has no column {joint_column!r}; its columns are {', '.join(table.names)}")
    joints = [(_joint(" ".join(filter(None, match.groups()))), table.names[i]) for match, i in found]
    return [(joint, partial(_recording, table, replace(place, speed=name))) for joint, name in joints]


def _joint(name: str) -> str:
    """Return the name of a joint, which is more than a number."""
    name = name.strip(" _-.").removesuffix(".0")
    return f"joint{name}" if name.isdecimal() else name


def _recording(table: Table, place: _Layout) -> Recording:
    path, columns = place.path, Columns(place.path, table.names)
    kind = BenchError if columns.known else NoRecordingError
    if not len(table.frame):
        raise kind(
            f"recording {path} has no line of numbers; it needs one for each sample, with the time and the motor's "
            "speed or position"
        )
    at, of, role = columns.chosen(place.speed, place.unit)
    if len(table.frame) < 3:
        raise kind(f"recording {path} has too few samples for a load turn: {len(table.frame)}")
    stamps = table.stamps(at)
    asked: dict[str, tuple[int, str | None]] = {} if stamps is not None else {"time": (at, None)}
    asked |= {role: (of, place.unit)}
    unit = columns.unit(of, role, place.unit)
    turn = UNITS[role][unit]
    lines, values = table.frame.index.to_numpy(), table.numbers(of)
    if not np.isfinite(values).any() and not columns.known:
        raise kind(
            f"recording {path} has no number in column {table.names[of]!r}, nor a heading that speaks of a speed"
        )
    if stamps is not None:
        seconds = stamps[0]
    else:
        seconds = table.numbers(at) / UNITS["time"][columns.unit(at, "time", None)]

    used = _inside(seconds, place.window, middle=role == "position")
    seconds, values, lines = seconds[used], values[used], lines[used]
    bad = ~(np.isfinite(values) & np.isfinite(seconds))
    if bad.sum() > MOST_MISSING * len(bad):
        line = int(lines[np.argmax(bad)])
        column = of if np.isfinite(seconds[np.argmax(bad)]) else at
        cell = table.frame.loc[line].iloc[column]
        found = f" but {str(cell)!r}" if isinstance(cell, str) else ""
        raise BenchError(
            f"recording {path}: line {line} has no number in column {table.names[column]!r}{found}; fix or cut it, or "
            "take a part without such lines (--window)"
        )
    seconds, values, lines = seconds[~bad], values[~bad], lines[~bad]
    if role == "position" and len(values):
        values = unwrapped(values, turn)
    first, values, repeated = merged(seconds, values / turn)
    seconds, lines = seconds[first], lines[first]
    if (back := np.diff(seconds) <= 0).any():
        raise BenchError(
            f"recording {path}: line {lines[np.argmax(back) + 1]}: time stands still or runs backwards"
            f" in column {table.names[at]!r}; sort or fix it"
        )
    try:
        dt, values, gaps = uniform(seconds, values)
    except BenchError as error:
        steps = np.diff(seconds)
        line = lines[np.argmax(steps > 1.5 * np.median(steps)) + 1]
        raise BenchError(
            f"recording {path}: line {line}: time is not uniform in column {table.names[at]!r}: {error}; resample it "
            "to equal steps, or take a part without a gap (--window)"
        ) from error
    lost = f"{bad.sum()} {'lines have' if bad.sum() > 1 else 'line has'} no number" if bad.any() else ""
    clock = f"time counts from {stamps[1]}" if stamps is not None else ""
    assumed = "; ".join(filter(None, (columns.assumed(asked), clock, lost, repeated, gaps)))
    start = float(seconds[0])
    if role == "speed":
        return Recording(start, dt, values, unit, assumed=assumed)
    return Recording(start + dt / 2, dt, np.diff(values) / dt, unit, assumed=assumed)


def _inside(time: Floats, window: Window, *, middle: bool) -> NDArray[np.bool_]:
    """Return flags (N,) of the samples that a window needs: those in it, or whose middle with the next lies in it.

    A sample without a time is inside where those beside it are.
    """
    known = np.isfinite(time)
    if window == (None, None) or known.sum() < 2:
        return np.ones(len(time), dtype=bool)
    place = np.arange(len(time))
    time = np.interp(place, place[known], time[known])
    step = abs(float(np.median(np.diff(time))))
    margin = step * (0.5 * middle + 1e-6)  # a limit at a sample's time includes the sample despite rounding
    begin, end = (-np.inf if window[0] is None else window[0], np.inf if window[1] is None else window[1])
    inside: NDArray[np.bool_] = (time >= begin - margin) & (time <= end + margin)
    if inside.sum() < 3:
        raise too_few(window, int(inside.sum()), float(time[0]), float(time[-1]))
    return inside
