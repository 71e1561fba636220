"""Commands for results: report and export."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.commands.says import Output
from bench.progress import steps


def report(
    folders: Annotated[
        list[Path], typer.Argument(metavar="OUTPUT…", help="A folder that 'bench run' wrote, or several to compare.")
    ],
    output: Annotated[
        Path | None,
        typer.Option(help="Folder to write; default: OUTPUT itself, and results/comparisons/NAMES for several."),
    ] = None,
) -> None:
    """Write the report of a study's folder: a page, tables (CSV, LaTeX), figures (SVG, PDF) and a methods paragraph.

    Several folders, such as those of two versions of an optimizer, are compared as one study.
    """
    report_on(folders, Console(), output)


def report_on(folders: list[Path], console: Console, output: Path | None = None) -> None:
    """Write the report and say where it is."""
    from bench.report import write_report

    with steps(console, "report") as on_progress:
        page = write_report(*folders, output=output, on_progress=on_progress)
    console.print(f"report: {page}", markup=False, highlight=False, soft_wrap=True)


def export(
    output: Output,
    kind: Annotated[str, typer.Option("--format", help="ioh, coco, csv or parquet (which needs the extra parquet).")],
    folder: Annotated[
        Path | None, typer.Option("--output", help="Folder to write; default: OUTPUT/export/FORMAT.")
    ] = None,
) -> None:
    """Write a study's results for other tools: IOHanalyzer, COCO's cocopp, or as plain tables."""
    from bench.export import export as export_results
    from bench.results import Results

    made = export_results(Results(output), kind, folder or output / "export" / kind)
    console = Console()
    for note in made.notes:
        console.print(f"note: {note}", style="yellow", markup=False, highlight=False, soft_wrap=True)
    console.print(f"export: {made.folder}", markup=False, highlight=False, soft_wrap=True)
