"""bench data: get the published recordings, and check them."""

from pathlib import Path
from typing import Annotated

import typer

from bench.cli.console import print_line
from bench.errors import BenchError

VARIABLE = "$BENCH_PUBLISHED_DATA"

data = typer.Typer(help="Get the thesis authors' published recordings, and check them.", no_args_is_help=True)


@data.command()
def fetch(
    source: Annotated[
        Path | None, typer.Option("--from", help="A folder that has them, such as a clone; nothing is downloaded.")
    ] = None,
    to: Annotated[Path | None, typer.Option(help=f"The folder to keep them in, instead of {VARIABLE}.")] = None,
) -> None:
    """Get the recordings that the thesis's authors published (20 MB), and check the SHA-256 of each."""
    from problems.backlash.published import download

    folder = to or download.data_folder()
    print_line(f"The recordings are the thesis authors' own: {download.SOURCE}\nTheir licence is {download.LICENCE}.")
    if source is None:
        download.download(folder, download.BASE_URL, on_file=print_line)
    elif source.is_dir():
        download.copy(source, folder, on_file=print_line)
    else:
        raise BenchError(f"{source} is no folder; give one that has the published files, such as a clone")
    missing, damaged = _faults(folder)
    lacking = ", ".join((*missing, *damaged))
    known = len(download.registry())
    whole = known - len(missing) - len(damaged)
    print_line(f"{folder} has {whole} of the {known} published files{f', without {lacking}' if lacking else ''}.")
    if folder.resolve() != download.data_folder().resolve():
        print_line(f"Set {download.VARIABLE} to it, so that the problems published-03 … find them.")


@data.command()
def verify(
    folder: Annotated[Path | None, typer.Argument(help=f"The folder to check; {VARIABLE} by default.")] = None,
) -> None:
    """Compare every published file with its SHA-256; end with 1 where one is damaged or missing."""
    from problems.backlash.published import download

    folder = folder or download.data_folder()
    missing, damaged = _faults(folder)
    for fault, names in (("damaged", damaged), ("missing", missing)):
        for name in names:
            print_line(f"{fault}: {name}")
    known = len(download.registry())
    whole = known - len(missing) - len(damaged)
    print_line(f"{whole} of the {known} published files in {folder} are whole.")
    if whole < known:
        raise typer.Exit(1)


def _faults(folder: Path) -> tuple[list[str], list[str]]:
    """Return the names of the published files that a folder lacks, and of those that it holds damaged."""
    from problems.backlash.published import download

    missing, damaged = [], []
    for name, file in download.registry().items():
        path, whole = download.look_up(file, folder)
        if path is None:
            missing.append(name)
        elif not whole:
            damaged.append(name)
    return missing, damaged
