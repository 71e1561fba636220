"""bench report: write the report of one study's folder, or of several compared."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.cli.console import Against, Jobs, Targets, print_line


def report(
    folders: Annotated[
        list[Path], typer.Argument(metavar="OUTPUT…", help="The folder that 'bench run' wrote, or several to compare.")
    ],
    output: Annotated[
        Path | None,
        typer.Option(help="Folder to write; default: OUTPUT, or results/comparisons/NAMES for several."),
    ] = None,
    jobs: Jobs = -1,
    against: Against = None,
    targets: Targets = None,
) -> None:
    """Write the report of a study's folder: a page, tables (CSV, LaTeX), figures (SVG, PDF) and a methods paragraph.

    Several folders, such as those of two versions of an optimizer, are compared as one study.
    """
    report_on([*folders, *published(against)], Console(), output, jobs, targets)


def published(names: list[str] | None) -> list[Path]:
    """Return the folders of published data sets, which are fetched and imported where they are not kept yet."""
    if not names:
        return []
    from bench.importing.archive import imported

    return [imported(name) for name in names]


def report_on(
    folders: list[Path], console: Console, output: Path | None = None, jobs: int = -1, targets: str | None = None
) -> None:
    """Write the report and print its path."""
    from bench.cli.progress import steps
    from bench.report import write_report
    from bench.storage.folder import Folder

    with steps(console, "report") as on_progress:
        page = write_report(*folders, output=output, n_jobs=jobs, targets=targets, on_progress=on_progress)
    for folder in folders:
        if (noted := Folder(folder).store_note()) and not noted.get("sound"):
            print_line(f"{folder}: {noted.get('sentence')}", "red", console)
    print_line(f"report: {page}", console=console)
