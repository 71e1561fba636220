"""Read the columns of a csv or other text file, a spreadsheet (xlsx) or a parquet file, and their units."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from io import BytesIO, StringIO
from itertools import takewhile
from math import isfinite, nan, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from bench.errors import BenchError, require
from bench.typing import Floats

if TYPE_CHECKING:
    import pandas as pd

# pandas is imported only for csv and parquet: its import takes longer than reading a spreadsheet without it.

HEAD = 20  # the rows of a spreadsheet among which its headings are looked for
OLD = bytes.fromhex("d0cf11e0a1b11ae1")  # the start of an .xls file and of an encrypted .xlsx file

UNITS = {
    "time": {"s": 1.0, "ms": 1e3, "us": 1e6},
    "speed": {"rps": 1.0, "rpm": 60.0, "rad/s": 2 * pi, "deg/s": 360.0},
    "position": {"rev": 1.0, "rad": 2 * pi, "deg": 360.0, "counts": nan},
}
"""By the role of a column, the number of each unit in one second, one turn per second, and one turn.

How many counts an encoder has a turn is known to its user alone.
"""

WORDS = tomllib.loads(Path(__file__).with_name("headings.toml").read_text(encoding="utf-8"))
_UNITS = {spelling: unit for unit, spellings in WORDS["units"].items() for spelling in (unit, *spellings)}
_SUFFIX = re.compile(r"(?:^|[\s_/,])(" + "|".join(map(re.escape, sorted(_UNITS, key=len, reverse=True))) + r")\)?$")
_BRACKET = re.compile(r"([\[(])([^\[\]()]*)[\])]$")


class Heading(NamedTuple):
    """The role and the unit of a column according to its heading.

    Attributes:
        role: "time", "speed", "position", or "" for any other column.
        rank: among several columns of a role, the one with the lowest rank is likeliest to be the motor's.
        plain: the heading without its unit, in lower case.
        unit: the unit that it names, or None.
        unknown: a unit in square brackets that is not in ``UNITS``, or "".
    """

    role: str
    rank: tuple[bool, bool, int]
    plain: str
    unit: str | None
    unknown: str


def is_unit(text: str) -> bool:
    """Return whether the text is a unit and nothing else, in brackets or not."""
    return _spelled(text).strip("[]() ") in _UNITS


def parse_heading(name: str) -> Heading:
    """Return the role and unit of a heading such as ``speed_rpm``, ``Drehzahl [1/min]`` or ``v (rad/s)``."""
    text, unit, unknown = _spelled(name), None, ""
    bracket = _BRACKET.search(text)
    if bracket and bracket[2].strip() in _UNITS:
        text, unit = text[: bracket.start()], _UNITS[bracket[2].strip()]
    elif bracket and bracket[1] == "[":  # round brackets hold remarks as well
        text, unknown = text[: bracket.start()], bracket[2].strip("- ")
    elif suffix := _SUFFIX.search(text):
        text, unit = text[: suffix.start()], _UNITS[suffix[1]]
    words = re.findall(r"[^\W\d_]+", text)
    role = next((role for role, spellings in WORDS["roles"].items() if {*spellings} & {*words}), "")
    if not words and unit is not None:  # a column called "rpm"
        role = next(role for role, units in UNITS.items() if unit in units)
    motor, not_motor = (bool({*WORDS["origins"][origin]} & {*words}) for origin in ("motor", "other"))
    rank = (not_motor, not motor, len(words))
    return Heading(role, rank, text.strip(" _/,"), unit, unknown)


def _spelled(text: str) -> str:
    return text.strip().lower().replace("µ", "u").replace("μ", "u").replace("°", "deg")


@dataclass(frozen=True, eq=False)
class Table:
    """The columns of a file.

    Attributes:
        names: the columns' headings; a column without one is called by its number, from "1".
        lines: the number in the file of each row's line.
        numbers: maps a column's index to its values, one a row, NaN where there is no number.
    """

    names: tuple[str, ...]
    lines: Sequence[int]
    numbers: Callable[[int], Floats]


def load(path: Path) -> Table:
    """Return the table of a csv, txt, xlsx or parquet file.

    Raises:
        BenchError: for a file of another kind, one that cannot be read, and for parquet without pyarrow.
    """
    kind = path.suffix.lower()
    if not path.exists():
        raise BenchError(f"recording {path}: there is no such file or folder")
    if kind not in READERS:
        raise BenchError(
            f"recording {path}: unknown kind of file {path.suffix!r}; give a .csv, .txt, .xlsx or .parquet file"
        )
    if kind == ".parquet":
        require("pyarrow", "parquet", f"recording {path}: parquet files need")
    try:
        return READERS[kind](path)
    except Exception as error:  # the readers raise many kinds for a damaged file
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise BenchError(f"recording {path} cannot be read: {reason}") from error


def _text(path: Path) -> Table:
    """Read text separated by semicolons, tabs, commas or blanks, with points or commas for decimals."""
    raw = path.read_bytes()
    encoding = "utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    lines = raw.decode(encoding, errors="replace").splitlines()
    filled = [line for line in lines if line and not line.isspace()]
    if not filled:
        raise BenchError("it is empty; export it again, with a line for each sample")
    middle = filled[len(filled) // 2]  # neither a heading nor a closing remark
    separator = next((mark for mark in (";", "\t", ",") if mark in middle), None)

    def split(line: str) -> list[str]:
        return [_plain(cell) for cell in line.lstrip("#% ").split(separator)]

    def is_heading(line: str) -> bool:
        return line.startswith(("#", "%")) or not any(map(_is_number, split(line)))

    above = sum(1 for _ in takewhile(is_heading, lines))
    body = lines[above:]
    width = max((len(line.split(separator)) for line in body), default=len(split(middle)))
    import pandas as pd

    cells = pd.read_csv(
        StringIO("\n".join(body) or "\n"),
        sep=separator or r"\s+",
        decimal="," if separator != "," and "," in middle else ".",
        header=None,
        names=range(width),
        skip_blank_lines=False,
        skipinitialspace=True,
        **_exact(),
    )
    cells.index = pd.RangeIndex(above + 1, above + 1 + len(cells))
    blank = [line for line in cells.index[cells.isna().all(axis=1)] if not "".join(lines[line - 1 : line]).strip()]
    return _frame_table(_names(map(split, lines[:above]), width), cells.drop(index=blank))


@cache
def _exact() -> dict[str, Any]:
    """Return the options with which ``pandas.read_csv`` reads every number to the last bit, the default from 3.1 on."""
    major, minor = version("pandas").split(".")[:2]
    return {} if (int(major), int(minor)) >= (3, 1) else {"float_precision": "round_trip"}


def _xlsx(path: Path) -> Table:
    rows = xlsx_rows(path.read_bytes())
    head = [[_plain(str(cell)) for cell in row] for row in rows[:HEAD]]
    above = sum(1 for _ in takewhile(lambda row: not any(map(_is_number, row)), head))
    width = len(rows[0]) if rows else 0
    return Table(
        _names(head[:above], width),
        range(above + 1, len(rows) + 1),
        lambda column: np.array([_number(_plain(row[column])) for row in rows[above:]]),
    )


def xlsx_rows(content: bytes) -> list[list[Any]]:
    """Return the rows of a workbook's first sheet, all of one length, without the empty ones at its end.

    A cell is a number (float), a text, a truth value, or a date or time; "" where it is empty or an error.

    Raises:
        BenchError: for a file that is no xlsx workbook, is damaged, or needs a password.
    """
    from python_calamine import CalamineWorkbook, SheetTypeEnum

    if content.startswith(OLD):
        raise BenchError("it is an old workbook (.xls) or has a password; save it as .xlsx without a password")
    try:
        book = CalamineWorkbook.from_filelike(BytesIO(content))
        names = [sheet.name for sheet in book.sheets_metadata if sheet.typ == SheetTypeEnum.WorkSheet]
        rows: list[list[Any]] = book.get_sheet_by_name(names[0]).to_python(skip_empty_area=False) if names else []
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # the reader's panics are no Exceptions
        raise BenchError(f"it is damaged, or no xlsx workbook ({str(error).partition(chr(10))[0]})") from error
    while rows and not any(cell != "" for cell in rows[-1]):
        rows.pop()
    width = len(rows[0]) if rows else 0
    while width and all(row[width - 1] == "" for row in rows):
        width -= 1
    return [row[:width] for row in rows]


def _parquet(path: Path) -> Table:
    import pandas as pd

    cells = pd.read_parquet(path, engine="pyarrow")
    if cells.index.name is not None:  # a time may be kept there
        cells = cells.reset_index()
    cells.index = pd.RangeIndex(1, len(cells) + 1)
    return _frame_table(tuple(map(str, cells.columns)), cells)


def _frame_table(names: tuple[str, ...], frame: pd.DataFrame) -> Table:
    """Return the table of a frame, whose index holds the numbers of the lines."""
    import pandas as pd

    def numbers(column: int) -> Floats:
        cells = frame.iloc[:, column]
        if not pd.api.types.is_numeric_dtype(cells):
            cells = pd.to_numeric(cells.astype(str).map(_plain, na_action="ignore"), errors="coerce")
        return cells.to_numpy(dtype=float, na_value=np.nan)

    return Table(names, frame.index.tolist(), numbers)


READERS: dict[str, Callable[[Path], Table]] = {".csv": _text, ".txt": _text, ".xlsx": _xlsx, ".parquet": _parquet}


def _names(headings: Any, width: int) -> tuple[str, ...]:
    """Return the names of the columns by the last full line of headings, and the units where these stand below."""
    full: list[Sequence[str]] = [row for row in headings if len(row) >= width > 0]
    if len(full) > 1 and all(is_unit(cell) for cell in full[-1] if cell):
        full[-1] = [f"{name} [{unit}]" if unit else name for name, unit in zip(full[-2], full[-1], strict=False)]
    last = full[-1] if full else [""] * width
    return tuple(last[i] or str(i + 1) for i in range(width))


def _plain(cell: Any) -> Any:
    """Return a text without blanks and quotes, its decimal comma a point where it is a number."""
    if not isinstance(cell, str):
        return cell
    cell = cell.strip(" '\"\t")
    return cell.replace(",", ".") if re.fullmatch(r"[-+]?\d*,\d*(?:[eE][-+]?\d+)?", cell) else cell


def _is_number(cell: str) -> bool:
    return isfinite(_number(cell))


def _number(cell: Any) -> float:
    """Return the number in a cell, NaN for any other content."""
    try:
        return float(cell)
    except (TypeError, ValueError, OverflowError):
        return nan
