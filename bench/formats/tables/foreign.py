"""Read tables of other tools, whatever their columns are called (:mod:`bench.results.foreign`)."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO, StringIO
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import pandas as pd

from bench.analysis.cells import NO_TRACE
from bench.errors import BenchError
from bench.formats import naming
from bench.formats.runs import FormatReader, ImportedRun, Reading, by_run, improvements, label, require_increasing
from bench.formats.source import Source
from bench.results.foreign import Table, are_problems, recognised

ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".xlsx", ".parquet", ".jsonl", ".json")


def is_index(source: Source, file: PurePosixPath) -> bool:
    """Return whether a file may be a table."""
    kind = file.suffix.lower()
    if kind in (".txt", ".dat"):  # others are notes
        return source.text(file).rstrip()[-1:].isdigit()
    return kind in ENDINGS


def runs(source: Source, files: Sequence[PurePosixPath], reading: Reading) -> Iterator[ImportedRun]:
    """Yield the runs of all files, which are one experiment.

    Raises:
        BenchError: where a file cannot be read, or its rows cannot be recognised.
    """
    tables = list(reading.each(files, lambda file: _tables(source, file)))
    if not tables:
        return
    found = recognised(tables, reading.columns, maximise=reading.maximise)
    reading.notes.extend(found.said)
    yield from _imported(found.rows, str(files[0]))


def _imported(rows: pd.DataFrame, where: str) -> Iterator[ImportedRun]:
    labels = {
        name: {text: label(text, f"{where}, {name},") for text in rows[name].unique()}
        for name in ("problem", "optimizer")
    }
    counted = "evaluations" in rows
    rows, runs_of = by_run(rows, ("problem", "optimizer", "run"))
    values = rows["value"].to_numpy(float)
    evaluations = rows["evaluations"].to_numpy(float).astype(np.int64) if counted else np.zeros(len(rows), np.int64)
    seeds = rows["seed"].tolist() if "seed" in rows else [None] * len(rows)
    for (problem, optimizer, number), run in runs_of:
        columns: dict[str, Any] = {} if seeds[run.start] is None else {"seed": seeds[run.start]}
        nfev, trace = 0, NO_TRACE
        if counted:
            require_increasing(evaluations[run], range(run.start + 2, run.stop + 2), where)
            nfev = int(evaluations[run.stop - 1])
            trace = improvements(evaluations[run], values[run])
        else:
            columns |= {"fun": float(values[run.start]), "nfev": None}
        name = labels["problem"][problem]
        yield ImportedRun(name, labels["optimizer"][optimizer], naming.dimension_of(name), nfev, trace, number, columns)


def _tables(source: Source, file: PurePosixPath) -> list[Table]:
    """Return the tables of a file: one, or one a sheet."""
    content, kind = source.bytes(file), file.suffix.lower()
    folder = file.parent.name
    try:
        if kind == ".xlsx":
            sheets = pd.read_excel(BytesIO(content), sheet_name=None, header=None, dtype=object, engine="calamine")
            filled = {name: cells for name, cells in sheets.items() if cells.size}
            if len(filled) > 1:
                return [Table(_headed(c), str(n), file.stem, f"{file}, sheet {n},") for n, c in filled.items()]
            cells = _headed(next(iter(filled.values()), pd.DataFrame()))
        elif kind == ".parquet":
            cells = pd.read_parquet(BytesIO(content)).reset_index()
        elif kind in (".json", ".jsonl"):
            cells = _json(content.decode("utf-8-sig"), lines=kind == ".jsonl")
        else:
            cells = _headed(_separated(_decoded(content)))
    except BenchError:
        raise
    except ImportError as error:
        raise BenchError(f"{file} needs pip install 'backlash-bench[parquet]'") from error
    except Exception as error:  # what the libraries raise for damaged files is of many kinds
        why = (str(error).strip() or repr(error)).splitlines()[0]
        raise BenchError(f"{file} cannot be read as a table: {why}") from error
    return [Table(cells, file.stem, folder, str(file))]


def _decoded(content: bytes) -> str:
    for encoding in ("utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig", "cp1252"):
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    return content.decode("utf-8", errors="replace")


def _separated(text: str) -> pd.DataFrame:
    """Return the cells of a text; semicolons and tabs go before commas, which may be decimal."""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "%"))]
    separator = next((each for each in ";\t," if lines and all(each in line for line in lines[:2])), None)
    if separator is None:
        rows = [line.split() for line in lines]
        if lines and (any(c.isalpha() for c in lines[0]) and len({len(row) for row in rows[:50]}) > 1):
            rows = [[line] for line in lines]
    else:
        rows = list(csv.reader(StringIO("\n".join(lines)), delimiter=separator, skipinitialspace=True))
    return pd.DataFrame(rows, dtype=object)


def _headed(cells: pd.DataFrame) -> pd.DataFrame:
    """Return cells under their heads; those of a file without heads are runs, or values where they are one column."""
    while len(cells) > 1 and cells.shape[1] > 2 and cells.iloc[0].fillna("").astype(str).str.strip().ne("").sum() < 2:
        cells = cells.iloc[1:]
    cells = cells.dropna(how="all", axis=1)
    if not cells.size:
        return pd.DataFrame()
    first = cells.iloc[0].fillna("").astype(str).str.strip()
    heads = pd.to_numeric(first.str.replace(",", "."), errors="coerce")
    counting = len(heads) > 2 and bool((heads.iloc[1:].diff().iloc[1:] == 1).all() and heads.iloc[1] % 1 == 0)
    if heads.notna().all() and not counting:
        body = cells
        names = ["value"] if cells.shape[1] == 1 else [f"run{place}" for place in range(1, cells.shape[1] + 1)]
    else:
        body = cells.iloc[1:]
        names = [f"{text.removesuffix('.0')}" or f"Unnamed {place}" for place, text in enumerate(first)]
    return body.set_axis(names, axis=1).reset_index(drop=True)


def _json(text: str, *, lines: bool) -> pd.DataFrame:
    """Return records, columns, or the runs of dictionaries of optimizers and problems."""
    found = [json.loads(line) for line in text.splitlines() if line.strip()] if lines else json.loads(text)
    if isinstance(found, Mapping) and len(found) == 1 and isinstance(next(iter(found.values())), list):
        (only,) = found.values()
        found = only if only and isinstance(only[0], Mapping) else found
    if isinstance(found, Mapping) and all(isinstance(each, Mapping) for each in found.values()):
        rows = [
            {"outer": outer, "inner": inner, "run": place, "value": _value(value)}
            for outer, within in found.items()
            for inner, values in within.items()
            if isinstance(values, list)
            for place, value in enumerate(values)
        ]
        if rows:
            outer = "problem" if are_problems(found) else "optimizer"
            inner = "optimizer" if outer == "problem" else "problem"
            return pd.DataFrame(rows).rename(columns={"outer": outer, "inner": inner})
    return pd.DataFrame(found)


def _value(found: Any) -> Any:
    """Return the value of a run that may be a pair of a point and its value."""
    if isinstance(found, Mapping):
        return next((found[name] for name in ("fun", "fitness", "best_fitness", "value", "f") if name in found), None)
    return found[-1] if isinstance(found, list) and found else found


READER = FormatReader("a table of results (csv, tsv, txt, xlsx, parquet, jsonl)", is_index, runs)
