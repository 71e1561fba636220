"""bench export: write results in the formats of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.cli.console import StudyFolder
from bench.formats import EXPORTABLE, described
from bench.helpers.console import print_line


def command(
    folder: StudyFolder,
    kind: Annotated[str, typer.Option("--format", help=f"{described(EXPORTABLE)}.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to write; default: FOLDER/export/FORMAT.")
    ] = None,
) -> None:
    """Write a study's results for other tools: for cocopp or IOHanalyzer, or as plain tables."""
    from bench.formats.exporting import export
    from bench.results.results import StoredResults

    output, results = output or folder / "export" / kind, StoredResults(folder)
    results.note_stores()
    for note in export(results, kind, output):
        print_line(f"note: {note}", "yellow")
    print_line(f"export: {output}")
