"""bench export: write results in the formats of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.cli.console import Output
from bench.formats import EXPORTABLE, described
from bench.helpers.console import print_line


def command(
    output: Output,
    kind: Annotated[str, typer.Option("--format", help=f"{described(EXPORTABLE)}.")],
    folder: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder to write; default: OUTPUT/export/FORMAT.")
    ] = None,
) -> None:
    """Write a study's results for other tools: for cocopp or IOHanalyzer, or as plain tables."""
    from bench.formats.exporting import export
    from bench.results.results import StoredResults

    folder, results = folder or output / "export" / kind, StoredResults(output)
    results.note_stores()
    for note in export(results, kind, folder):
        print_line(f"note: {note}", "yellow")
    print_line(f"export: {folder}")
