"""bench data: get the published recordings, each checked."""

from pathlib import Path
from typing import Annotated

import typer

from bench.helpers import print_line
from problems.backlash.commands import PANEL
from problems.backlash.published import download

data = typer.Typer(help="Get the thesis authors' published recordings.", no_args_is_help=True, rich_help_panel=PANEL)


@data.callback()
def group() -> None:
    """Keep ``fetch`` a command of its own, where it is the only one."""


@data.command()
def fetch(
    to: Annotated[
        Path | None, typer.Option(help=f"The folder to keep them in, instead of ${download.VARIABLE}.")
    ] = None,
) -> None:
    """Get the recordings that the thesis's authors published (20 MB), and check the SHA-256 of each.

    Those that are there and whole stay as they are.
    """
    folder = to or download.data_folder()
    print_line(f"The recordings are the thesis authors' own: {download.SOURCE}\nTheir licence is {download.LICENCE}.")
    download.download(download.registry(), folder, download.BASE_URL, on_file=print_line)
    print_line(f"{folder} has the {len(download.registry())} published files.")
    if folder.resolve() != download.data_folder().resolve():
        print_line(f"Set {download.VARIABLE} to it, so that the problems published-03 … find them.")
