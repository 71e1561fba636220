"""bench pack: write a study's folder into one archive."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.cli.console import StudyFolder
from bench.helpers.console import print_line


def command(
    folder: StudyFolder,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Archive to write; default: FOLDER.zip.")
    ] = None,
) -> None:
    """Write a study's folder into one archive, for Zenodo or a paper's supplement.

    The zip file has trials, frozen study, environments, hashes of data and code, the report, and the SHA-256 of every
    file (SHA256SUMS). The same folder gives the same bytes.
    """
    from bench.formats.archive import pack

    packed = pack(folder, output)
    for note in packed.notes:
        print_line(f"note: {note}", "yellow")
    print_line(f"{packed.trials:,} trials in {packed.files:,} files: {packed.path}")
