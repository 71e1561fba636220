"""Read tables of other tools, whatever their columns are called (:mod:`bench.results.foreign`)."""

from __future__ import annotations

import csv
import json
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import PurePosixPath

import numpy as np
import pandas as pd

from bench.analysis.cells import NO_TRACE
from bench.formats import naming
from bench.formats.runs import FormatReader, ImportedRun, Reading, by_run, improvements, label, require_increasing
from bench.formats.source import Source
from bench.helpers.errors import BenchError
from bench.helpers.parsing import Json
from bench.results.foreign import Table, are_problems, recognised
from bench.trial.columns import Row

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
    rows, said = recognised(tables, reading.columns, maximise=reading.maximise)
    reading.notes.extend(said)
    reading.maximise = bool(rows["more"].any())
    for name in ("problem", "optimizer"):
        rows[name] = rows[name].map({text: label(text, f"{files[0]}, {name},") for text in rows[name].unique()})
    rows, runs_of = by_run(rows, ("problem", "optimizer", "run"))
    values, seeds = rows["value"].to_numpy(float), rows.get("seed")
    evaluations = rows["evaluations"].to_numpy(np.int64) if "evaluations" in rows else None
    for (problem, optimizer, number), run in runs_of:
        columns: Row = {} if seeds is None else {"seed": int(seeds.iloc[run.start])}
        nfev, trace = 0, NO_TRACE
        if evaluations is not None:
            require_increasing(evaluations[run], range(run.start + 2, run.stop + 2), str(files[0]))
            nfev, trace = int(evaluations[run.stop - 1]), improvements(evaluations[run], values[run])
        else:
            columns |= {"fun": float(values[run.start]), "nfev": None}
        yield ImportedRun(problem, optimizer, naming.dimension_of(problem), nfev, trace, number, columns)


def _tables(source: Source, file: PurePosixPath) -> list[Table]:
    """Return the tables of a file: one, or one a sheet."""
    content, kind = BytesIO(source.bytes(file)), file.suffix.lower()
    try:
        if kind == ".xlsx":
            sheets = pd.read_excel(content, sheet_name=None, header=None, dtype=object, engine="calamine")
            filled = {str(name): _headed(cells) for name, cells in sheets.items() if cells.size}
            if len(filled) > 1:
                return [Table(cells, name, file.stem, f"{file}, sheet {name},") for name, cells in filled.items()]
            cells = next(iter(filled.values()), pd.DataFrame())
        elif kind == ".parquet":
            cells = pd.read_parquet(content).reset_index()
        elif kind == ".jsonl":
            cells = pd.DataFrame([json.loads(line) for line in content if line.strip()])  # with every digit
        elif kind == ".json":
            cells = _records(json.load(content))
        else:
            cells = _headed(_separated(content.read()))
    except ImportError as error:
        raise BenchError(f"{file} needs pip install 'backlash-bench[parquet]'") from error
    except Exception as error:  # what the libraries raise for damaged files is of many kinds
        why = (str(error).strip() or repr(error)).splitlines()[0]
        raise BenchError(f"{file} cannot be read as a table: {why}") from error
    return [Table(cells, file.stem, file.parent.name, str(file))]


def _separated(content: bytes) -> pd.DataFrame:
    """Return the cells of a text; semicolons and tabs go before commas, which may be decimal."""
    try:
        text = content.decode("utf-16" if content[:2] in (BOM_UTF16_LE, BOM_UTF16_BE) else "utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "%"))]
    separator = next((each for each in ";\t," if lines and all(each in line for line in lines[:2])), None)
    if separator is not None:
        rows = list(csv.reader(lines, delimiter=separator, skipinitialspace=True))
    elif any(map(str.isalpha, "".join(lines[:1]))) and len({len(line.split()) for line in lines[:50]}) > 1:
        rows = [[line] for line in lines]  # a column under a head of several words
    else:
        rows = [line.split() for line in lines]
    return pd.DataFrame(rows, dtype=object)


def _headed(cells: pd.DataFrame) -> pd.DataFrame:
    """Return cells under their heads; those of a file without heads are runs, or values where they are one column."""
    while len(cells) > 1 and cells.shape[1] > 2 and (cells.iloc[0].fillna("").astype(str).str.strip() != "").sum() < 2:
        cells = cells.iloc[1:]  # a title
    cells = cells.dropna(how="all", axis=1)
    if not cells.size:
        return pd.DataFrame()
    heads = cells.iloc[0].fillna("").astype(str).str.strip()
    numbers = pd.to_numeric(heads.str.replace(",", "."), errors="coerce")
    counting = len(heads) > 2 and bool((numbers.iloc[1:].diff().iloc[1:] == 1).all() and numbers.iloc[1] % 1 == 0)
    if numbers.notna().all() and not counting:
        names = ["value"] if len(heads) == 1 else [f"run{place}" for place in range(1, len(heads) + 1)]
        return cells.set_axis(names, axis=1).reset_index(drop=True)
    names = [text.removesuffix(".0") or f"Unnamed {place}" for place, text in enumerate(heads)]
    return cells.iloc[1:].set_axis(names, axis=1).reset_index(drop=True)


def _records(found: Json) -> pd.DataFrame:
    """Return records, columns, or the runs of dictionaries of optimizers and problems."""
    values = [*found.values()] if isinstance(found, Mapping) else []
    if len(values) == 1 and isinstance(values[0], list) and values[0] and isinstance(values[0][0], Mapping):
        return pd.DataFrame(values[0])
    nested = found.items() if values and all(isinstance(each, Mapping) for each in values) else ()
    runs = pd.Series({(outer, inner): cell for outer, within in nested for inner, cell in within.items()}, dtype=object)
    if not any(isinstance(cell, list) for cell in runs):
        return pd.DataFrame(found)
    roles = ["problem", "optimizer"] if are_problems(found) else ["optimizer", "problem"]
    return runs.rename_axis(roles).explode().map(_value).reset_index(name="value")


def _value(found: object) -> object:
    """Return the value of a run that may be a pair of a point and its value, or a record with it."""
    if isinstance(found, Mapping):
        return next((found[name] for name in ("fun", "fitness", "best_fitness", "value", "f") if name in found), None)
    return found[-1] if isinstance(found, list) and found else found


READER = FormatReader("a table of results (csv, tsv, txt, xlsx, parquet, jsonl)", is_index, runs)
