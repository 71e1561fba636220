"""bench data: get the published recordings, and check them."""

from pathlib import Path
from typing import Annotated

import typer

from bench.errors import BenchError
from problems.backlash.published import download as files

data = typer.Typer(help="The thesis authors' published recordings: get them, and check them.", no_args_is_help=True)


@data.command()
def fetch(
    source: Annotated[
        Path | None, typer.Option("--from", help="A folder that has them, such as a clone; nothing is downloaded.")
    ] = None,
    to: Annotated[
        Path | None, typer.Option(help=f"The folder to keep them in, instead of ${files.VARIABLE}'s.")
    ] = None,
) -> None:
    """Get the recordings that the thesis's authors published (20 MB), each checked by its SHA-256."""
    folder = to or files.data_folder()
    typer.echo(f"The recordings are the thesis authors' own: {files.SOURCE}\nTheir licence is {files.LICENCE}.")
    if source is None:
        files.download(folder, files.BASE_URL, on_file=typer.echo)
    elif source.is_dir():
        files.copy(source, folder, on_file=typer.echo)
    else:
        raise BenchError(f"{source} is no folder; give one that has the published files, such as a clone")
    lacking = [name for names in _lacks(folder) for name in names]
    without = f", without {', '.join(lacking)}" if lacking else ""
    whole = len(files.registry()) - len(lacking)
    typer.echo(f"{folder} has {whole} of the {len(files.registry())} published files{without}.")
    if folder.resolve() != files.data_folder().resolve():
        typer.echo(f"Set {files.VARIABLE} to it, so that the problems published-03 … find them.")


@data.command()
def verify(
    folder: Annotated[Path | None, typer.Argument(help=f"The folder to check; ${files.VARIABLE}'s by default.")] = None,
) -> None:
    """Compare every published file with its SHA-256; ends with 1 where one is damaged or missing."""
    folder = folder or files.data_folder()
    missing, damaged = _lacks(folder)
    for name in damaged:
        typer.echo(f"damaged: {name}")
    for name in missing:
        typer.echo(f"missing: {name}")
    whole = len(files.registry()) - len(damaged) - len(missing)
    typer.echo(f"{whole} of the {len(files.registry())} published files in {folder} are whole.")
    if whole < len(files.registry()):
        raise typer.Exit(1)


def _lacks(folder: Path) -> tuple[list[str], list[str]]:
    """Return the names of the files that a folder does not have, and of those it has, but not as published."""
    missing, damaged = [], []
    for name, file in files.registry().items():
        path, whole = files.look_up(file, folder)
        if path is None:
            missing.append(name)
        elif not whole:
            damaged.append(name)
    return missing, damaged
