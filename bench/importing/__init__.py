"""Bring in the results of other tools as a study's folder: COCO's data, IOHprofiler's, and plain tables (CSV).

An imported folder is read, reported on, compared and exported like any other. Its rows refer to one record in
``environment.json`` that marks them as imported; what the source does not hold, such as seeds and times, is missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from bench.errors import BenchError
from bench.helpers.text import printable
from bench.importing import coco, ioh, ioh_info, tables
from bench.importing.runs import Reading
from bench.importing.source import opened
from bench.importing.write import numbered, study_of, write
from bench.storage import provenance
from bench.study.entries import LONGEST_LABEL

__all__ = ["FORMATS", "Imported", "import_results"]


FORMATS = {"coco": coco, "ioh": ioh, "ioh-info": ioh_info, "csv": tables}
"""The reader of each format by its name; a source is of one of them."""


@dataclass(frozen=True)
class Imported:
    """What was imported: the format, the numbers of trials, problems and optimizers, and what a reader should know.

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
) -> Imported:
    """Import a folder, a tar or zip archive, or a CSV file into a new study's folder, whole or not at all.

    Args:
        source: what holds the results, in one of :data:`FORMATS`.
        output: the folder to write, which must be missing or empty.
        name: what the source is called in the study and its environment; its file name by default.
        licence: under which the results were published, where it is known.
        partial: whether to leave out the indices and logs that cannot be read, which the result, ``environment.json``
            and reports list.

    Raises:
        BenchError: where the source is of no format or of several, is damaged or cut short, holds results of several
            suites, of several objectives or of maximisation, unsorted evaluations or another optimum than this
            project's, or cannot be read, and where the output cannot be written.
    """
    started = provenance.now()
    with opened(Path(source)) as contents:
        indices = {}
        for kind, reader in FORMATS.items():
            if files := [file for file in contents.files if reader.is_index(contents, file)]:
                indices[kind] = files
        if len(indices) != 1:
            raise BenchError(
                f"{source} holds results of {' and of '.join(indices)}; import one of them at a time"
                if indices
                else f"{source} holds no results in a known format: neither an index of COCO (.info), nor one of "
                f"IOHprofiler (.json, .info), nor a table ({', '.join(tables.COLUMNS)})"
            )
        ((kind, files),) = indices.items()
        reading = Reading(partial)
        runs = numbered(FORMATS[kind].runs(contents, files, reading))
        if not runs:
            raise BenchError("; ".join([f"{source} holds no run that can be read", *reading.left_out[:1]]))
        called = printable(name or contents.name, LONGEST_LABEL)
        study = study_of(called, runs)
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
    write(Path(output), study, runs, record)
    return Imported(
        kind, len(runs), len(study.problems), len(study.optimizers), tuple(reading.notes), tuple(reading.left_out)
    )
