"""The cells of a file of columns: csv and other text, xlsx, parquet."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import StringIO
from itertools import islice, takewhile
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench.errors import BenchError, require
from bench.problem import Floats
from problems.backlash.recordings.units import is_unit


@dataclass(frozen=True, eq=False)
class Table:
    """The columns of a file.

    Attributes:
        names: the columns' headings; a column without one is called by its number, from "1".
        cells: a row a sample, under its line's number in the file.
    """

    names: tuple[str, ...]
    cells: pd.DataFrame

    def numbers(self, column: int) -> Floats:
        """Return a column's values, NaN where there is no number."""
        cells = self.cells.iloc[:, column]
        if not pd.api.types.is_numeric_dtype(cells):
            cells = pd.to_numeric(cells.astype(str).map(_plain), errors="coerce")
        return cells.to_numpy(dtype=float, na_value=np.nan)


def load(path: Path) -> Table:
    """Return the table of a csv, txt, xlsx or parquet file.

    Raises:
        BenchError: for a file of another kind, one that cannot be read, and for parquet without pyarrow.
    """
    kind = path.suffix.lower()
    if kind not in READERS:
        raise BenchError(
            f"recording {path}: unknown kind of file {path.suffix!r}; give a .csv, .txt, .xlsx or .parquet file"
        )
    if kind == ".parquet":
        require("pyarrow", "parquet", f"recording {path}: parquet files need")
    try:
        return READERS[kind](path)
    except FileNotFoundError as error:
        raise BenchError(f"recording {path}: there is no such file") from error
    except Exception as error:  # the readers raise many kinds for a damaged file
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise BenchError(f"recording {path} cannot be read: {reason}") from error


def _text(path: Path) -> Table:
    """Read text separated by semicolons, tabs, commas or blanks, with points or commas for decimals."""
    raw = path.read_bytes()
    encoding = "utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    lines = raw.decode(encoding, errors="replace").splitlines()
    filled = [line for line in lines if line and not line.isspace()]
    middle = filled[len(filled) // 2] if filled else ""  # neither a heading nor a closing remark
    separator = next((mark for mark in (";", "\t", ",") if mark in middle), None)

    def split(line: str) -> list[str]:
        return [_plain(cell) for cell in line.lstrip("#% ").split(separator)]

    def is_heading(line: str) -> bool:
        return line.startswith(("#", "%")) or not any(map(_is_number, split(line)))

    above = sum(1 for _ in takewhile(is_heading, lines))
    body = lines[above:]
    width = max((len(line.split(separator)) for line in body), default=len(split(middle)))
    cells = pd.read_csv(
        StringIO("\n".join(body) or "\n"),
        sep=separator or r"\s+",
        decimal="," if separator != "," and "," in middle else ".",
        header=None,
        names=range(width),
        skip_blank_lines=False,
        skipinitialspace=True,
    )
    cells.index = pd.RangeIndex(above + 1, above + 1 + len(cells))
    blank = [line for line in cells.index[cells.isna().all(axis=1)] if not "".join(lines[line - 1 : line]).strip()]
    return Table(_names(map(split, lines[:above]), width), cells.drop(index=blank))


def _xlsx(path: Path) -> Table:
    cells = pd.read_excel(path, header=None)
    rows = [["" if pd.isna(cell) else _plain(str(cell)) for cell in row] for row in islice(cells.values, 20)]
    above = sum(1 for _ in takewhile(lambda row: not any(map(_is_number, row)), rows))
    cells.index = pd.RangeIndex(1, len(cells) + 1)
    return Table(_names(rows[:above], cells.shape[1]), cells.iloc[above:].infer_objects())


def _parquet(path: Path) -> Table:
    cells = pd.read_parquet(path, engine="pyarrow")
    if cells.index.name is not None:  # a time may be kept there
        cells = cells.reset_index()
    cells.index = pd.RangeIndex(1, len(cells) + 1)
    return Table(tuple(map(str, cells.columns)), cells)


READERS: dict[str, Callable[[Path], Table]] = {".csv": _text, ".txt": _text, ".xlsx": _xlsx, ".parquet": _parquet}


def _names(headings: Any, width: int) -> tuple[str, ...]:
    """Return the names of the columns by the last full line of headings, and the units where these stand below."""
    full: list[Sequence[str]] = [row for row in headings if len(row) >= width > 0]
    if len(full) > 1 and all(is_unit(cell) for cell in full[-1] if cell):
        full[-1] = [f"{name} [{unit}]" if unit else name for name, unit in zip(full[-2], full[-1], strict=False)]
    last = full[-1] if full else [""] * width
    return tuple(last[i] or str(i + 1) for i in range(width))


def _plain(cell: str) -> str:
    """Return a cell without blanks and quotes, its decimal comma a point where it is a number."""
    cell = cell.strip(" '\"\t")
    return cell.replace(",", ".") if DECIMAL.fullmatch(cell) else cell


DECIMAL = re.compile(r"[-+]?\d*,\d*(?:[eE][-+]?\d+)?")


def _is_number(cell: str) -> bool:
    try:
        return isfinite(float(cell))
    except ValueError:
        return False
