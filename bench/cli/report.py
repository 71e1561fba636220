"""bench report: write the report of one study's folder, or of several compared."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from bench.cli.console import Jobs, Subject
from bench.helpers.console import print_line, steps


def command(
    folders: Annotated[
        list[Path],
        typer.Argument(
            metavar="FOLDER",
            help="The folder that 'bench run' wrote, or several to compare.",
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Folder to write; default: FOLDER, or results/comparisons/NAMES for several."
        ),
    ] = None,
    jobs: Jobs = -1,
    against: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Compare with a published data set of COCO's archive, such as bbob/BIPOP-CMA-ES, or show the running "
            "times of the best of 2009 (best2009); repeatable.",
        ),
    ] = None,
    subject: Subject = None,
    optimizer: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Show these optimizers alone, as in 'gwo*'; repeatable. Needs --output."),
    ] = None,
    problem: Annotated[
        list[str] | None, typer.Option(metavar="PATTERN", help="Show these problems alone; repeatable. Needs --output.")
    ] = None,
    dimension: Annotated[
        list[int] | None, typer.Option(help="Show the problems of this dimension alone; repeatable. Needs --output.")
    ] = None,
    versions: Annotated[
        list[str] | None,
        typer.Option(
            metavar="OPTIMIZER", help="Also show its earlier versions in the folder; repeatable. Needs --output."
        ),
    ] = None,
    targets: Annotated[
        str | None,
        typer.Option(
            help="What counts as reached: precisions, runlength, relative, quantiles, tolerance, or a list such as "
            "'1e-1,1e-3' (the best value less the optimum) or '5%,1%' (of the optimum).",
        ),
    ] = None,
    columns: Annotated[
        int, typer.Option(min=1, max=2, help="Fit LaTeX tables and figures to a text of one column or of two.")
    ] = 1,
) -> None:
    """Write the report of a study's folder: a page, tables (CSV, LaTeX), figures (SVG, PDF) and a methods paragraph.

    Several folders, such as those of two versions of an optimizer, are compared as one study. A selection of
    optimizers or problems says on its page what is left out.
    """
    chosen = {"optimizers": optimizer or None, "problems": problem or None, "dimensions": dimension or None}
    beside, best = published(against)
    settings = {
        "output": output,
        "n_jobs": jobs,
        "targets": targets,
        "subject": subject,
        "columns": columns,
    }
    report_on([*folders, *beside], Console(), beside_best=best, versions=versions or (), **settings, **chosen)


def published(names: list[str] | None) -> tuple[list[Path], bool]:
    """Return the folders of published data sets, fetched and imported where they are not kept yet.

    And whether ``"best2009"``, which has no folder, is among the names.
    """
    if not names:
        return [], False
    from bench.formats.coco.best2009 import NAME
    from bench.formats.coco.published import imported

    return [imported(name) for name in names if name != NAME], NAME in names


def report_on(folders: list[Path], console: Console, **settings: Any) -> None:
    """Write the report with settings of :func:`bench.write_report`, and print its answer and its path."""
    from bench.cli.answer import as_lines, read
    from bench.topics.write import write_report

    with steps(console, "report") as on_progress:
        page = write_report(*folders, on_progress=on_progress, **settings)
    console.print(as_lines(read(page.parent)))
    print_line(f"report: {page}", console=console)
