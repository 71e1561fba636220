"""bench archive: list and get published results of COCO's data archive."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.errors import BenchError
from bench.helpers.console import print_line

archive = typer.Typer(help="List and get published results of COCO's data archive.", no_args_is_help=True)

From = Annotated[
    Path | None,
    typer.Option("--from", help="A folder that has the archive's files and list; nothing is downloaded."),
]


@archive.command("list")
def list_sets(
    suite: Annotated[str, typer.Argument(help="A suite of the archive.")] = "bbob", source: From = None
) -> None:
    """List the published data sets of a suite: name, size in MB, and whether it is kept here."""
    from bench.formats.coco.published import data_folder, data_sets

    for data in data_sets(suite, source):
        kept = ", kept" if (data_folder() / data.suite / data.path).is_file() else ""
        print_line(f"{data.name}  {data.kilobytes / 1000:.1f} MB{kept}")


@archive.command()
def fetch(
    names: Annotated[list[str], typer.Argument(metavar="NAME…", help="Data sets, such as bbob/BIPOP-CMA-ES.")],
    source: From = None,
) -> None:
    """Get published data sets, and check the SHA-256 of each; --against of 'bench report' uses them."""
    from bench.formats.coco.published import fetch as fetch_set

    if source is not None and not source.is_dir():
        raise BenchError(f"{source} is no folder; give one that has the archive's files and list")
    for name in names:
        print_line(f"{name}: {fetch_set(name, source)}")
