"""Read the table in a csv or other text file, a spreadsheet (xlsx) or a parquet file, by pandas."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import version
from io import BytesIO
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from bench.contract.typing import Floats
from bench.helpers.errors import BenchError, require
from problems.backlash.recordings.headings import is_unit

if TYPE_CHECKING:
    import pandas as pd

# pandas is imported only where a file is read: its import would make every command wait.

HEAD = 1 << 16  # bytes of a text file, of which its form is inferred
HEAD_ROWS = 100  # the rows of a spreadsheet among which its headings are looked for
OLD = bytes.fromhex("d0cf11e0a1b11ae1")  # the start of an .xls file and of an encrypted .xlsx file

CLOCK = r"\d{1,2}:\d\d(:\d\d([.,]\d+)?)?"
DATE = re.compile(rf"(\d{{4}}-?\d\d?-?\d\d?|\d\d?[./-]\d\d?[./-]\d{{4}})([T ,]+\d|$)|{CLOCK}$")
DAY_FIRST = r"^(\d\d?)[./-](\d\d?)[./-](\d{4})"
ZONE = r"\s*(?:UTC|GMT|[A-Z]{3,4})$"  # of all stamps; their differences do not depend on it


@dataclass(frozen=True, eq=False)
class Table:
    """The columns of a file.

    Attributes:
        names: the columns' headings; a column without one is called by its number, from "1".
        frame: a row for each line with a sample, whose index is the number of the line in the file.
    """

    names: tuple[str, ...]
    frame: pd.DataFrame

    def numbers(self, column: int) -> Floats:
        """Return the values of a column by its index, NaN where there is no number."""
        import pandas as pd

        cells = self.frame.iloc[:, column]
        if pd.api.types.is_numeric_dtype(cells):
            return cells.to_numpy(dtype=float, na_value=np.nan)
        numbers = pd.to_numeric(cells, errors="coerce").astype(float)
        missed = numbers.isna() & cells.notna()
        return np.asarray(numbers.where(~missed, cells[missed].map(_number)), dtype=np.float64)

    def stamps(self, column: int) -> tuple[Floats, str] | None:
        """Return the seconds since the first date or time of a column, NaN where there is none, and that first one.

        ISO 8601 is read, and days, months and years in this order. Return None for a column of something else.
        """
        import pandas as pd

        cells = self.frame.iloc[:, column]
        filled = cells.dropna()
        if pd.api.types.is_numeric_dtype(cells) or not len(filled):
            return None
        if not pd.api.types.is_datetime64_any_dtype(cells):
            if not DATE.match(_plain(str(filled.iloc[0]))):
                return None
            text = cells.astype(str).str.strip(" '\"\t").str.replace(",", ".").str.replace(ZONE, "", regex=True)
            if re.fullmatch(CLOCK, text[filled.index[0]]):
                cells = pd.to_timedelta(text, errors="coerce")
            else:
                text = text.str.replace(r"\.? +(?=\d)", "T", n=1, regex=True).str.replace(DAY_FIRST, _iso, regex=True)
                cells = pd.to_datetime(text, format="ISO8601", utc=True, errors="coerce")
            filled = cells.dropna()
            if not len(filled):
                return None
        return (cells - filled.iloc[0]).dt.total_seconds().to_numpy(), str(self.frame.loc[filled.index[0]].iloc[column])

    def by(self, column: int) -> dict[str, Table]:
        """Return the table of each value of a column, in the order of their first rows."""
        groups = self.frame.groupby(self.frame.columns[column], sort=False)
        return {_plain(str(value)): replace(self, frame=rows) for value, rows in groups}


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
    import pandas as pd

    with path.open("rb") as file:
        raw = file.read(HEAD)
    encoding = _encoding(raw)
    lines = raw.decode(encoding, errors="replace").splitlines()
    if len(raw) == HEAD and len(lines) > 1:
        lines.pop()  # it may be cut
    filled = [line for line in lines if line and not line.isspace()]
    if not filled:
        raise BenchError("it is empty; export it again, with a line for each sample")
    middle = filled[len(filled) // 2]  # neither a heading nor a closing remark
    separator = next((mark for mark in (";", "\t", ",") if mark in middle), None)
    if separator == "," and len(middle.split()) > 1 and all(map(_is_number, middle.split())):
        separator = None  # a comma for decimals, between blanks

    def split(line: str) -> list[str]:
        text = line.lstrip("#% ")
        cells = text.split() if separator is None else next(csv.reader([text], delimiter=separator), [])
        return [_plain(cell) for cell in cells]

    above, names = _head((line.startswith(("#", "%")) for line in lines), map(split, lines), split(middle))
    width = max(len(names), *(len(line.split(separator)) for line in lines[above:])) if lines[above:] else len(names)
    frame = pd.DataFrame(columns=range(width))
    if lines[above:]:
        try:
            frame = pd.read_csv(
                path, sep=separator or r"\s+", decimal="," if separator != "," and "," in middle else ".",
                header=None, names=range(width), index_col=False, skiprows=above, skip_blank_lines=False,
                skipinitialspace=True, encoding=encoding, encoding_errors="replace", low_memory=False,
                float_precision=_precision(),
            )  # fmt: skip
        except pd.errors.ParserError as error:
            raise BenchError(f"{str(error).strip()}; mend or cut that line") from error
    return _table(names, frame.set_axis(range(above + 1, above + 1 + len(frame))).dropna(how="all"))


def _encoding(raw: bytes) -> str:
    """Return the encoding of a text by its beginning: UTF-16 and UTF-8, else that of Windows in Western Europe."""
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    try:
        raw[: len(raw) - 3].decode("utf-8-sig")  # the last letter may be cut
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


@cache
def _precision() -> Literal["round_trip"] | None:
    """Return the ``float_precision`` with which pandas reads every number to the last bit, the default from 3.1 on."""
    major, minor = version("pandas").split(".")[:2]
    return None if (int(major), int(minor)) >= (3, 1) else "round_trip"


def _xlsx(path: Path) -> Table:
    cells = first_sheet(path.read_bytes())
    *rows, middle = (
        [
            ["" if cell != cell else _plain(str(cell)) for cell in row]
            for row in cells.iloc[[*range(min(len(cells), HEAD_ROWS)), len(cells) // 2]].to_numpy(dtype=object)
        ]
        if len(cells)
        else [[]]
    )
    above, names = _head([False] * len(rows), rows, middle)
    return _table(names, cells.set_axis(range(1, len(cells) + 1)).iloc[above:].dropna(how="all"))


def first_sheet(content: bytes) -> pd.DataFrame:
    """Return the cells of a workbook's first sheet, without headings; NaN where one is empty or an error.

    Columns to the right of the last filled one are left out: whether the reader returns formulas that were never
    computed depends on its version.

    Raises:
        BenchError: for a file that is no xlsx workbook, is damaged, or needs a password.
    """
    import pandas as pd

    if content.startswith(OLD):
        raise BenchError("it is an old workbook (.xls) or has a password; save it as .xlsx without a password")
    try:
        with pd.ExcelFile(BytesIO(content), engine="calamine") as book:
            cells = pd.read_excel(book, book.sheet_names[0], header=None) if book.sheet_names else pd.DataFrame()
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # the reader's panics are no Exceptions
        raise BenchError(f"it is damaged, or no xlsx workbook ({str(error).partition(chr(10))[0]})") from error
    return cells.iloc[:, : 1 + max(np.flatnonzero(cells.notna().any()), default=-1)]


def _parquet(path: Path) -> Table:
    import pandas as pd

    frame = pd.read_parquet(path, engine="pyarrow")
    if frame.index.name is not None:  # a time may be kept there
        frame = frame.reset_index()
    return _table(tuple(map(str, frame.columns)), frame.set_axis(range(1, len(frame) + 1)))


READERS: dict[str, Callable[[Path], Table]] = {".csv": _text, ".txt": _text, ".xlsx": _xlsx, ".parquet": _parquet}


def _table(names: Sequence[str], frame: pd.DataFrame) -> Table:
    """Return the table of a frame, whose index holds the numbers of the lines."""
    width = frame.shape[1]
    numbered = (str(i + 1) for i in range(len(names), width))
    return Table((*names[:width], *numbered), frame.set_axis(range(width), axis=1))


def _head(remarks: Iterable[bool], rows: Iterable[Sequence[str]], middle: Sequence[str]) -> tuple[int, list[str]]:
    """Return how many rows stand above the samples, and the names of the columns.

    The samples begin with the first row that has a number or a time where the ``middle`` row has its first one. What
    stands before it is a preamble; the last row of it that has a cell for each of the middle's is the headings', or,
    where it has units alone, the one before.
    """
    column = next((i for i, cell in enumerate(middle) if _is_value(cell)), len(middle))
    width = max((i + 1 for i, cell in enumerate(middle) if cell), default=0)
    full: list[list[str]] = []
    above = 0
    for is_remark, row in zip(remarks, rows, strict=True):
        if not is_remark and len(row) > column and _is_value(row[column]):
            break
        above += 1
        if len(row) >= width > 0:
            full.append(list(row))
    if len(full) > 1 and all(is_unit(cell) for cell in full[-1] if cell):
        full[-1] = [f"{name} [{unit}]" if unit else name for name, unit in zip(full[-2], full[-1], strict=False)]
    last = full[-1] if full else [""] * width
    return above, [name or str(i + 1) for i, name in enumerate(last)]


def _plain(cell: str) -> str:
    """Return a text without blanks and quotes, its decimal comma a point where it is a number."""
    cell = cell.strip(" '\"\t")
    return cell.replace(",", ".") if re.fullmatch(r"[-+]?\d*,\d*(?:[eE][-+]?\d+)?", cell) else cell


def _is_number(cell: str) -> bool:
    return isfinite(_number(cell))


def _is_value(cell: str) -> bool:
    return _is_number(cell) or DATE.match(cell) is not None


def _number(cell: Any) -> float:
    """Return the number in a cell, NaN for any other content."""
    try:
        return float(_plain(cell) if isinstance(cell, str) else cell)
    except (TypeError, ValueError, OverflowError):
        return float("nan")


def _iso(match: re.Match[str]) -> str:
    """Return day, month and year in the order of ISO 8601."""
    return f"{match[3]}-{match[2]:0>2}-{match[1]:0>2}"
