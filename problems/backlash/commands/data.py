"""bench data: get the published recordings, and check them."""

from pathlib import Path
from typing import Annotated

import typer

from bench.helpers import print_line
from problems.backlash.commands import PANEL
from problems.backlash.published import download

data = typer.Typer(
    help="Get the thesis authors' published recordings, and check them.", no_args_is_help=True, rich_help_panel=PANEL
)


@data.command()
def fetch(
    to: Annotated[
        Path | None, typer.Option(help=f"The folder to keep them in, instead of ${download.VARIABLE}.")
    ] = None,
) -> None:
    """Get the recordings that the thesis's authors published (20 MB), and check the SHA-256 of each."""
    folder = to or download.data_folder()
    print_line(f"The recordings are the thesis authors' own: {download.SOURCE}\nTheir licence is {download.LICENCE}.")
    download.download(download.registry(), folder, download.BASE_URL, on_file=print_line)
    *_, whole = download.faults(download.registry(), folder)
    print_line(f"{folder} has {whole}.")
    if folder.resolve() != download.data_folder().resolve():
        print_line(f"Set {download.VARIABLE} to it, so that the problems published-03 … find them.")


@data.command()
def verify(
    folder: Annotated[
        Path | None, typer.Argument(help=f"The folder to check; ${download.VARIABLE} by default.")
    ] = None,
) -> None:
    """Compare every published file with its SHA-256; end with 1 where one is damaged or missing."""
    folder = folder or download.data_folder()
    missing, damaged, whole = download.faults(download.registry(), folder)
    for line in (*(f"damaged: {name}" for name in damaged), *(f"missing: {name}" for name in missing)):
        print_line(line)
    print_line(f"{whole} in {folder} are whole.")
    if missing or damaged:
        raise typer.Exit(1)
