"""Read plain tables (CSV): problem, optimizer, trial, evaluations, value; one row an evaluation that is worth noting.

The rows of a run must be in order of evaluations, and other runs may come between them. Values need not improve; the
last row of a run says how many evaluations it made. A folder with ``improvements.csv`` and ``trials.csv``, as this
package exports them, is imported with all that the table of trials holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from io import BytesIO
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import pandas as pd

from bench.analysis.cells import NO_TRACE
from bench.contract.objective import Trace
from bench.formats import naming
from bench.formats.runs import FormatReader, ImportedRun, Reading, by_run, improvements, label, require_increasing
from bench.formats.source import Source
from bench.helpers.errors import BenchError
from bench.trial.columns import FEATURES, RESERVED, STORED, Row

COLUMNS = ("problem", "optimizer", "trial", "evaluations", "value")
IMPROVEMENTS, TRIALS = "improvements.csv", "trials.csv"
KEYS = ["problem", "optimizer", "trial"]
_COUNTS, _NUMBERS, _TEXTS = (
    tuple(column.name for column in STORED if column.kind is kind and column.frame) for kind in (int, float, str)
)


def is_index(source: Source, file: PurePosixPath) -> bool:
    """Return whether a file is a table with the columns."""
    if file.suffix != ".csv":
        return False
    with (source.root / file).open("rb") as opened:
        head = opened.readline(10_000).decode("utf-8-sig", errors="replace")
    return set(COLUMNS) <= {cell.strip().strip('"') for cell in head.split(",")}


def runs(source: Source, tables: Sequence[PurePosixPath], reading: Reading) -> Iterator[ImportedRun]:
    """Return the runs of every table.

    Raises:
        BenchError: with the line that cannot be read, or whose evaluations do not increase.
    """
    return reading.each(tables, partial(_runs_of, source))


def _runs_of(source: Source, file: PurePosixPath) -> Iterator[ImportedRun]:
    beside = file.with_name(TRIALS)
    whole = file.name == IMPROVEMENTS and beside in source.files
    return _exported(source, file, beside) if whole else _plain(source, file)


def _plain(source: Source, file: PurePosixPath) -> Iterator[ImportedRun]:
    for (problem, optimizer, number), nfev, trace in _traces(_table(source, file), file):
        yield ImportedRun(problem, optimizer, naming.dimension_of(problem), nfev, trace, number)


def _traces(table: pd.DataFrame, file: PurePosixPath) -> Iterator[tuple[tuple[str, str, int], int, Trace]]:
    """Yield problem, optimizer and trial of each run, its last evaluation and its trace, in order of first rows."""
    rows, runs = by_run(table, KEYS)
    evaluations, values = (
        rows[name].to_numpy(kind) for name, kind in (("evaluations", np.int64), ("value", np.float64))
    )
    lines = rows["line"].to_numpy()
    for (problem, optimizer, number), run in runs:
        require_increasing(evaluations[run], lines[run], str(file))
        last = int(evaluations[run.stop - 1])
        yield (problem, optimizer, number), last, improvements(evaluations[run], values[run])


def _read(source: Source, file: PurePosixPath) -> pd.DataFrame:
    """Return a table as texts, missing ones as ""; a row is cut short where it has fewer cells than the header."""
    content = source.bytes(file)
    try:
        table = pd.read_csv(BytesIO(content), dtype=str, keep_default_na=False, encoding="utf-8-sig")
    except (ValueError, pd.errors.ParserError) as error:
        raise BenchError(f"{file} cannot be read as a table: {str(error).strip().splitlines()[0]}") from error
    if content and not content.endswith((b"\n", b"\r")):
        raise BenchError(f"{file} is cut short: its last line has no end")
    return table.rename(columns=str.strip).assign(line=np.arange(2, len(table) + 2))


def _table(source: Source, file: PurePosixPath) -> pd.DataFrame:
    table = _read(source, file)
    for name in ("trial", "evaluations"):
        table[name] = _counts(table, name, file, all_given=True)
    table["value"] = _numbers(table, "value", file)
    for wrong, what in ((table["value"].isna(), "no value"), (table["value"] == -np.inf, "the value -inf")):
        if wrong.any():
            raise BenchError(f"{file}, line {table.loc[wrong, 'line'].iloc[0]}, has {what}")
    for name in ("problem", "optimizer"):
        labels = {text: label(text, f"{file}, column {name},") for text in table[name].unique()}
        table[name] = table[name].map(labels)
    return table


def _counts(table: pd.DataFrame, name: str, file: PurePosixPath, *, all_given: bool = False) -> list[int | None]:
    """Return a column of whole numbers, which rows may lack unless all are to be given; only seeds have 19 digits."""
    texts = table[name].str.strip()
    digits = 15 if all_given else 19
    wrong = ~texts.str.fullmatch(f"[0-9]{{1,{digits}}}") & (all_given | (texts != ""))
    if wrong.any():
        row = table[wrong].iloc[0]
        raise BenchError(f"{file}, line {row['line']}, has {row[name]!r} as {name}, which is no whole number from 0")
    return [int(text) if text else None for text in texts]


def _numbers(table: pd.DataFrame, name: str, file: PurePosixPath) -> pd.Series[float]:
    try:
        texts: list[str] = table[name].tolist()
        return pd.Series([float(text) if text.strip() else np.nan for text in texts], index=table.index)
    except ValueError as error:
        raise BenchError(f"{file} has a {name} that is no number: {error}") from error


def _exported(source: Source, file: PurePosixPath, trials: PurePosixPath) -> Iterator[ImportedRun]:
    """Yield the trials of this package's own export, with those that failed."""
    traces = {key: trace for key, _, trace in _traces(_table(source, file), file)}
    table = _read(source, trials)
    if lacking := [name for name in ("problem", "optimizer", "trial", "status", "fun", "nfev") if name not in table]:
        raise BenchError(f"{trials} has no column {lacking[0]!r}")
    table["trial"] = _counts(table, "trial", trials, all_given=True)
    reserved = {*RESERVED, *(column.name for column in FEATURES), "line"}
    measured = {
        name: _numbers(table, name, trials).tolist()
        for name in map(str, table)
        if name not in reserved or name in _NUMBERS
    }
    known: dict[str, list[Any]] = {name: _counts(table, name, trials) for name in _COUNTS if name in table}
    for name in _NUMBERS:
        if name in measured:
            known[name] = [None if np.isnan(each) else each for each in measured.pop(name)]
    known |= {name: [text or None for text in table[name]] for name in _TEXTS if name in table}
    for place, key in enumerate(zip(*(table[name] for name in KEYS), strict=True)):
        columns: Row = {name: column[place] for name, column in known.items()}
        if columns["status"] == "ok":
            given = {name: column[place] for name, column in measured.items() if not np.isnan(column[place])}
            columns["x"] = {name[2:]: number for name, number in given.items() if name.startswith("x_")}
            columns["metrics"] = {name: number for name, number in given.items() if not name.startswith("x_")}
        problem, optimizer = (label(text, str(trials)) for text in key[:2])
        dimension = naming.dimension_of(problem) or len(columns.get("x", ())) or None
        trace = traces.get(key, NO_TRACE)
        yield ImportedRun(problem, optimizer, dimension, columns["nfev"] or 0, trace, key[2], columns)


READER = FormatReader(f"a table ({', '.join(COLUMNS)})", is_index, runs)
