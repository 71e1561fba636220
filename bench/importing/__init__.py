"""Bring in the results of other tools as a study's folder: COCO's data, IOHprofiler's, and plain tables (CSV).

An imported folder is read, reported on, compared and exported like any other. Its rows refer to one record in
``environment.json`` that marks them as imported; what the source does not hold, such as seeds and times, is missing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from bench.errors import BenchError
from bench.helpers.text import printable
from bench.importing import coco, ioh, ioh_info, tables
from bench.importing.runs import Reading, Run
from bench.importing.source import Source, opened
from bench.importing.write import numbered, study_of, write
from bench.storage import provenance
from bench.study.entries import LONGEST_LABEL

__all__ = ["FORMATS", "Imported", "import_results"]


class _Format(NamedTuple):
    is_index: Callable[[Source, PurePosixPath], bool]
    runs: Callable[[Source, Sequence[PurePosixPath], Reading], Iterator[Run]]


FORMATS = {
    name: _Format(module.is_index, module.runs)
    for name, module in {"coco": coco, "ioh": ioh, "ioh-info": ioh_info, "csv": tables}.items()
}
"""The formats by name; a source is of one of them."""


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
    with opened(Path(source)) as found:
        indices = {kind: [file for file in found.files if each.is_index(found, file)] for kind, each in FORMATS.items()}
        kinds = [kind for kind, files in indices.items() if files]
        if len(kinds) != 1:
            raise BenchError(
                f"{source} holds results of {' and of '.join(kinds)}; import one of them at a time"
                if kinds
                else f"{source} holds no results in a known format: neither an index of COCO (.info), nor one of "
                f"IOHprofiler (.json, .info), nor a table ({', '.join(tables.COLUMNS)})"
            )
        reading = Reading(partial)
        runs = numbered(FORMATS[kinds[0]].runs(found, indices[kinds[0]], reading))
        if not runs:
            raise BenchError("; ".join([f"{source} holds no run that can be read", *reading.left_out[:1]]))
        called = printable(name or found.name, LONGEST_LABEL)
        study = study_of(called, runs)
        record = {
            "imported": called,
            "format": kinds[0],
            "sha256": found.sha256,
            "licence": licence,
            "left_out": reading.left_out,
            "importer": provenance.package(),
            "started": started,
            "ended": provenance.now(),
            "command": provenance.command(),
        }
    write(Path(output), study, runs, record)
    return Imported(
        kinds[0], len(runs), len(study.problems), len(study.optimizers), tuple(reading.notes), tuple(reading.left_out)
    )
