"""bench unpack: unpack an archive of results, all of it verified."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.helpers.console import print_line


def command(
    file: Annotated[Path, typer.Argument(help="The archive that 'bench pack' wrote.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write: a new one.")],
    limit: Annotated[float, typer.Option(metavar="GB", min=0, help="The most that all files may take.")] = 20.0,
) -> None:
    """Unpack an archive of results into a new folder, and verify every file and every trial.

    An archive that was changed, or from which anything is missing, is refused, and nothing of it is unpacked.
    """
    from bench.formats.archive import unpack

    folder = unpack(file, output, limit_gb=limit)
    print_line(f"{folder.files:,} files in {folder.path}: {folder.sentence}")
