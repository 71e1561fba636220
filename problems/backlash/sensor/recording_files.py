"""Find recordings by paths and folders, and infer the joint and the time of each from its name.

>>> paths = find(["cell7", "spare/joint5.xlsx"])
>>> [(one.name, one.unit, one.at) for one in series(paths)]

A folder stands for the recordings in it and in its subfolders. A name with a date (``joint4_2024-01.csv``,
``2024-01-15.csv``, ``20240115_joint4.csv``) gives the time of the recording; the rest of the name, with the folder,
identifies the joint. Without a date, a number that is not the joint's own gives the time (``joint4_003.csv``); without
either, the order of the files does.
"""

import re
from calendar import monthrange
from collections.abc import Sequence
from dataclasses import dataclass
from os.path import commonpath
from pathlib import Path

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash import TRUTH
from problems.backlash.recordings.tables import READERS

DATE = re.compile(
    r"(?<!\d)(?P<year>(?:19|20)\d\d)(?P<by>[-_.]?)(?P<month>0[1-9]|1[0-2])(?:(?P=by)(?P<day>0[1-9]|[12]\d|3[01]))?"
    r"(?:[T_ -](?P<hour>[01]\d|2[0-3])[-:h.]?(?P<minute>[0-5]\d)(?:[-:.]?[0-5]\d)?)?(?!\d)"
)
JOINT = re.compile(r"(?<![^\W\d_])(?:joint|axis|achse|gelenk|giunto|asse|axe|j)[ _-]?\d+", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class Series:
    """Recordings of one joint in the order of their times.

    Attributes:
        name: the part that the names of its files share, "" for none.
        members: (n,) positions in the list of files.
        at: (n,) when each was made, not decreasing: months since the year 0, the number in the name, or 1, 2, ….
        unit: the unit of ``at``: "month", "number" or "file".
        days: whether a name has the day, too.
    """

    name: str
    members: tuple[int, ...]
    at: Floats
    unit: str
    days: bool = False

    def label(self, at: float) -> str:
        """Return a time in usual writing, such as ``2024-01``, ``2024-01-15``, or the number."""
        if self.unit != "month":
            return f"{at:.4g}"
        year, month = divmod(int(at), 12)
        day = 1 + int(at % 1 * monthrange(year, month + 1)[1] + 1e-6)
        return f"{year}-{month + 1:02d}" + (f"-{day:02d}" if self.days else "")


@dataclass(frozen=True)
class _Name:
    """The parts of a file's name: the joint, and the time as a date or a number."""

    joint: str
    at: float | None = None
    unit: str = "file"
    days: bool = False


def find(arguments: Sequence[str | Path]) -> list[Path]:
    """Return the files that paths and folders stand for, each once, without the truth of a wear curve.

    Raises:
        BenchError: for a folder without recordings.
    """
    paths: dict[Path, None] = {}
    for argument in map(Path, arguments):
        files = [argument]
        if argument.is_dir():
            files = sorted(filter(_is_recording, (*argument.iterdir(), *argument.glob("*/*"))), key=natural)
            if not files:
                raise BenchError(f"there is no recording in the folder {argument}; give {', '.join(READERS)} files")
        paths |= dict.fromkeys(files)
    return list(paths)


def natural(path: Path) -> list[tuple[str, int, str]]:
    """Return a key by which ``a2.csv`` sorts before ``a10.csv``, and a folder's own files before its subfolders'."""
    parts = re.split(r"(\d+)", str(path.parent).lower() + "\0" + path.name.lower())
    return [("", int(part), part) if part.isdecimal() else (part, 0, "") for part in parts]


def short_names(paths: Sequence[Path]) -> list[str]:
    """Return the files' names without the folders that all of them share."""
    if len(paths) < 2:
        return [path.name for path in paths]
    parents = [path.absolute().parent for path in paths]
    if len({parent.anchor for parent in parents}) > 1:
        return [str(path) for path in paths]
    shared = commonpath(parents)
    return [(parent / path.name).relative_to(shared).as_posix() for parent, path in zip(parents, paths, strict=True)]


def display_names(paths: Sequence[Path], joints: Sequence[str]) -> list[str]:
    """Return the short names of recordings, with the joint in brackets where the file has several."""
    return [f"{name} ({joint})" if joint else name for name, joint in zip(short_names(paths), joints, strict=True)]


def series(paths: Sequence[Path], joints: Sequence[str] | None = None) -> list[Series]:
    """Return recordings joint by joint, in the order in which the joints first appear.

    Args:
        paths: the file of each; one of several joints is there for each of them.
        joints: the name of each one's joint within its file, "" for a file of one joint; None where all are such.
    """
    joints = [""] * len(paths) if joints is None else joints
    names = [_parse(Path(name)) for name in short_names(paths)]
    groups: dict[tuple[str, str, str], list[int]] = {}
    for i, (name, joint) in enumerate(zip(names, joints, strict=True)):
        groups.setdefault((name.joint, joint, name.unit), []).append(i)
    made = []
    for (*parts, unit), members in groups.items():
        at = np.array([float(n + 1) if (time := names[i].at) is None else time for n, i in enumerate(members)])
        order = np.argsort(at, kind="stable")
        days = any(names[i].days for i in members)
        joint = " ".join(filter(None, parts))
        made.append(Series(joint, tuple(members[i] for i in order), at[order], unit, days))
    return made


def _is_recording(path: Path) -> bool:
    is_hidden = path.name == TRUTH or path.name.startswith((".", "~$"))
    return path.suffix.lower() in READERS and not is_hidden and path.is_file()


def _parse(path: Path) -> _Name:
    stem, folder = path.stem, "" if path.parent == Path() else path.parent.as_posix()
    if (date := DATE.search(stem)) and (at := _months(date)) is not None:
        after = re.sub(r"^[\W_]*\d+$", "", stem[date.end() :])  # repeated on one day
        return _Name(_joined(folder, stem[: date.start()], after), at, "month", date["day"] is not None)
    joint = JOINT.search(stem)
    numbers = [m for m in re.finditer(r"\d+", stem) if joint is None or not joint.start() <= m.start() < joint.end()]
    if numbers:
        last = numbers[-1]
        return _Name(_joined(folder, stem[: last.start()], stem[last.end() :]), float(last[0]), "number")
    return _Name(_joined(folder, joint[0] if joint else "", ""))


def _joined(folder: str, before: str, after: str) -> str:
    name = " ".join(part for text in (before, after) if (part := text.strip(" _-.")))
    return "/".join(part for part in (folder, name) if part)


def _months(date: re.Match[str]) -> float | None:
    """Return the months since the year 0, the day and the hour as parts of one, or None for 31 February."""
    year, month, day, hour, minute = (int(date[part] or 0) for part in ("year", "month", "day", "hour", "minute"))
    length = monthrange(year, month)[1]
    if day > length:
        return None
    return year * 12 + month - 1 + (max(day, 1) - 1 + (hour * 60 + minute) / 1440) / length
