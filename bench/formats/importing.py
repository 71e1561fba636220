"""Bring in the results of other tools as a study's folder.

An imported folder is read, reported on, compared and exported like any other. Its rows refer to one record in
``environment.json`` that marks them as imported; what the source does not hold, such as seeds and times, is missing.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from bench.formats import FORMATS, IMPORTABLE, naming
from bench.formats.runs import ImportedRun, Reading
from bench.formats.source import opened
from bench.helpers.atomic import replacing
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.helpers.text import printable
from bench.plugins.loading import IMPORTED
from bench.storage import provenance
from bench.storage.folder import Folder
from bench.study import Entry, Study
from bench.study.budget import Budget
from bench.study.entries import LONGEST_LABEL
from bench.trial.columns import Row, packed

TABLE = "table"
"""The format of results that are in none of the others."""


@dataclass(frozen=True)
class Imported:
    """The outcome of an import: the format, and the numbers of trials, problems and optimizers.

    ``left_out`` has a sentence on each file that could not be read, empty unless those may be left out.
    """

    format: str
    trials: int
    problems: int
    optimizers: int
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()


def import_results(
    source: str | PathLike[str],
    output: str | PathLike[str],
    *,
    name: str | None = None,
    licence: str | None = None,
    partial: bool = False,
    columns: Mapping[str, str] | None = None,
    maximise: bool = False,
) -> Imported:
    """Import a folder, a tar or zip archive, or a CSV file into a new study's folder, whole or not at all.

    Args:
        source: what holds the results, in one of :data:`bench.formats.IMPORTABLE`.
        output: the folder to write, which must be missing or empty.
        name: what the source is called in the study and its environment; its file name by default.
        licence: under which the results were published, where it is known.
        partial: whether to leave out the indices and logs that cannot be read, which the result, ``environment.json``
            and reports list.
        columns: of a table of another tool, the names of columns by what they are
            (:data:`bench.results.foreign.SYNONYMS`).
        maximise: whether higher values of such a table are better.

    Raises:
        BenchError: where the source is of no format or of several, is damaged or cut short, holds results of several
            suites, of several objectives or of maximisation, unsorted evaluations or another optimum than this
            project's, or cannot be read, and where the output cannot be written.
    """
    started = provenance.now()
    with opened(Path(source)) as contents:
        readers = {kind: FORMATS[kind].reader for kind in IMPORTABLE}
        indices = {
            kind: files
            for kind, reader in readers.items()
            if kind != TABLE and (files := [file for file in contents.files if reader.is_index(contents, file)])
        }
        if not indices or (set(indices) == {"csv"} and (columns or maximise)):  # other formats have such files, too
            tables = [file for file in contents.files if readers[TABLE].is_index(contents, file)]
            indices = {TABLE: tables} if tables else {}
        if len(indices) != 1:
            raise BenchError(
                f"{source} holds results of {' and of '.join(indices)}; import one of them at a time"
                if indices
                else f"{source} holds no results in a known format: neither "
                f"{', nor '.join(reader.index for reader in readers.values())}"
            )
        ((kind, files),) = indices.items()
        reading = Reading(partial, columns=columns or {}, maximise=maximise and kind == TABLE)
        runs = _numbered(readers[kind].runs(contents, files, reading))
        if not runs:
            raise BenchError("; ".join([f"{source} holds no run that can be read", *reading.left_out[:1]]))
        called = printable(name or contents.name, LONGEST_LABEL).replace("\n", " ")
        study = _study_of(called, runs, negated=reading.maximise)
        record = {
            "imported": called,
            "format": kind,
            "sha256": contents.sha256,
            "licence": licence,
            "left_out": reading.left_out,
            "importer": provenance.package(),
            "started": started,
            "ended": provenance.now(),
            "command": provenance.command(),
        }
    _write(Path(output), study, runs, record)
    return Imported(
        kind, len(runs), len(study.problems), len(study.optimizers), tuple(reading.notes), tuple(reading.left_out)
    )


def _study_of(name: str, runs: Sequence[ImportedRun], *, negated: bool) -> Study:
    """Return the study that numbered runs make up.

    Its budget is the largest number of evaluations of any run, by dimension where all dimensions are known: other tools
    have no budget that every run may spend.
    """
    problems = {run.problem: run.dimension for run in runs}
    optimizers = dict.fromkeys(run.optimizer for run in runs)
    spent: dict[int | None, int] = {}
    for run in runs:
        spent[run.dimension] = max(run.nfev, spent.get(run.dimension, 1))
    budget = Budget.read(max(spent.values()))
    if len(spent) > 1 and None not in spent:
        budget = Budget.read({str(size): most for size, most in sorted(spent.items(), key=lambda item: item[0] or 0)})
    clean = re.sub(
        r"[^A-Za-z0-9._-]+", "-", re.sub(r"\.(tgz|tar(\.\w+)?|zip|csv|tsv|txt|xlsx|parquet|jsonl?)$", "", name)
    ).strip("._-")[:100]
    return Study(
        clean or "imported",
        tuple(Entry(label if naming.is_offered(label) else f"{IMPORTED}:{label}", label) for label in problems),
        tuple(Entry(f"{IMPORTED}:{label}", label) for label in optimizers),
        trials=1 + max(run.number or 0 for run in runs),
        budget=budget,
        title=f"Imported from {name}" + "; values are negated where higher is better" * negated,
    )


def _numbered(runs: Iterable[ImportedRun]) -> list[ImportedRun]:
    """Return the runs with the numbers of their trials: those given, or their order within their cell.

    Raises:
        BenchError: for a number that is given twice.
    """
    results: dict[tuple[str, str, int], ImportedRun] = {}
    counts: Counter[tuple[str, str]] = Counter()
    for run in runs:
        number = counts[run.problem, run.optimizer] if run.number is None else run.number
        counts[run.problem, run.optimizer] += 1
        if (key := (run.problem, run.optimizer, number)) in results:
            raise BenchError(f"trial {number} of {run.optimizer} on {run.problem} occurs twice")
        results[key] = replace(run, number=number)
    return [*results.values()]


def _write(folder: Path, study: Study, runs: Iterable[ImportedRun], record: JsonObject) -> None:
    """Write a study's folder in which every row refers to the one environment, ``record``.

    Raises:
        BenchError: where the folder holds anything, or cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise BenchError(f"{folder} is there already and not empty; give another -o")
    with replacing(folder) as temporary:
        temporary.mkdir(parents=True)
        target = Folder(temporary)
        target.claim(study)
        target.note_selected(study)
        with target.store.writer() as writer:
            number = writer.record("environments", record)
            with writer.transaction():
                for run in runs:
                    writer.put(_row(run) | {"environment": number})
        target.write_environments()
        if folder.is_dir():
            folder.rmdir()  # it is empty


def _row(run: ImportedRun) -> Row:
    """Return a run as a row of the store, with NULL for unknown values."""
    row: Row = {"status": "ok", "fun": run.fun, "nfev": run.nfev, "x": {}, "metrics": {}} | dict(run.columns)
    trace = {"trace": run.trace} if row["status"] == "ok" else {}
    return packed(row | trace) | {"problem": run.problem, "optimizer": run.optimizer, "trial": run.number}
