"""bench import: bring in the results of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.formats import IMPORTABLE, described
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError
from bench.helpers.text import count

COCO = "coco:"
"""Before the name of a data set of COCO's archive."""


def command(
    source: Annotated[
        str,
        typer.Argument(
            metavar="FOLDER|FILE|coco:NAME",
            help=f"A folder, a tar or zip archive, or a table. {described(IMPORTABLE)}. Or a published data set of "
            "COCO's archive, such as coco:bbob/DIRECT ('bench list archives'), or a table of a paper (see 'bench "
            "reproduce').",
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", help="The folder to write, missing or empty; of a paper's table, that of your trials."
        ),
    ],
    licence: Annotated[
        str | None, typer.Option(help="The licence under which the results were published, where you know it.")
    ] = None,
    files: Annotated[
        Path | None,
        typer.Option("--from", help="Of coco:NAME: a folder with the archive's files; nothing is downloaded."),
    ] = None,
    partial: Annotated[
        bool, typer.Option("--partial", help="Leave out the files that cannot be read, and list them.")
    ] = False,
    column: Annotated[
        list[str] | None,
        typer.Option(
            help="What a column of a table is, such as optimizer=Algo, problem=, run=, value= or evaluations=."
        ),
    ] = None,
    maximise: Annotated[bool, typer.Option("--maximise", help="Higher values of the table are better.")] = False,
) -> None:
    """Import results of COCO, of IOHprofiler or tables of any tool as a study's folder.

    COCO and IOHprofiler write folders with an index (.info, or .json of IOHprofiler) and logs (.dat, .tdat). A table
    (csv, tsv, xlsx, parquet, jsonl) has a row for each run, or a column for each optimizer or problem; the command
    prints what it took for what, and --column and --maximise correct it. Data sets of COCO's archive are checked
    against its list of hashes and kept. The folder is read like any other: 'bench report MINE IMPORTED' compares both.
    Imported trials cannot be repeated. A file that is damaged, or of maximisation, ends the import; --partial imports
    the others, and reports list what is missing.
    """
    path = Path(source)
    from bench.formats.importing import import_results

    if wrong := [each for each in column or () if "=" not in each]:
        raise BenchError(f"--column {wrong[0]!r} needs what it is and its name, such as optimizer=Algo")
    columns = {each.partition("=")[0]: each.partition("=")[2] for each in column or ()}
    name = None
    if source.startswith(COCO):
        from bench.formats.coco.published import fetch, find

        name = find(source.removeprefix(COCO), files).name
        path = fetch(name, files)
    imported = import_results(
        path, output, name=name, licence=licence, partial=partial, columns=columns, maximise=maximise
    )
    for note in imported.notes:
        print_line(f"note: {note}", "yellow")
    for sentence in imported.left_out:
        print_line(f"left out: {sentence}", "red")
    print_line(
        f"imported {count(imported.trials, 'trial')} of {count(imported.optimizers, 'optimizer')} on "
        f"{count(imported.problems, 'problem')} ({imported.format}): {output}"
    )
