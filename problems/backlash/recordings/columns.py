"""Find the columns of a table, and their units, by the headings."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from bench.helpers.errors import BenchError, nearest
from problems.backlash.recordings.headings import UNITS, parse_heading

Column = str | int


class Columns:
    """The columns of a file by their names; every error is a BenchError with the file's path."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self._path, self._names = path, names
        self._headings = [parse_heading(name) for name in names]

    @property
    def known(self) -> bool:
        """Whether a heading speaks of a time, a speed or a position."""
        return any(heading.role for heading in self._headings)

    def chosen(self, speed: Column | None, unit: str | None) -> tuple[int, int, str]:
        """Return the columns of time and of the speed or position, and which of the two the latter is.

        Args:
            speed: the column asked for; None to recognise it.
            unit: its unit; None for that of its heading.
        """
        if len(self._names) < 2:
            raise BenchError(f"recording {self._path} has no two columns, of time and of speed or position")
        at, of, role = self.find("time", None), self.find("speed", speed), "speed"
        if of is None and (other := self.find("position", None)) is not None:
            role, of = "position", other
        if at is None:
            at = 0 if of != 0 else 1
        if of is None:
            of = next(i for i in range(len(self._names)) if i != at)
        if of == at:
            raise BenchError(f"recording {self._path}: column {self._names[at]!r} cannot be both time and {role}")
        heading = self._headings[of].role
        if heading == "position" or (heading != "speed" and unit in UNITS["position"]):
            role = "position"
        return at, of, role

    def find(self, role: str, wanted: Column | None) -> int | None:
        """Return the index of the wanted column, or else of the column recognised as the role's, or None."""
        if wanted is not None:
            return self.named(str(wanted).strip())
        columns = [i for i, heading in enumerate(self._headings) if heading.role == role]
        columns.sort(key=lambda i: self._headings[i].rank)
        if len(columns) > 1 and self._headings[columns[0]].rank == self._headings[columns[1]].rank:
            names = " or ".join(repr(self._names[i]) for i in columns[:2])
            remedy = "name it (--speed)" if role == "speed" else "rename one of them"
            raise BenchError(f"recording {self._path}: the {role} may be {names}; {remedy}")
        return columns[0] if columns else None

    def named(self, wanted: str) -> int:
        """Return the index of a column by its heading, with or without its unit, or by its number from 1."""
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

    def assumed(self, used: Mapping[str, tuple[int, str | None]]) -> str:
        """Return a sentence on the columns whose role or unit no heading says, by role their index and given unit."""
        assumptions = []
        for role, (column, asked) in used.items():
            if asked is not None or self._headings[column].unit in UNITS[role]:
                continue
            assumptions.append(f"column {self._names[column]!r} for the {role} in {self.unit(column, role, asked)}")
        return (
            f"without a heading with a unit, the reader took {' and '.join(assumptions)}; headings such as time_ms and "
            "speed_rpm, or --speed and --unit, change it"
            if assumptions
            else ""
        )
