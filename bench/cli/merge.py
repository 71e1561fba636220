"""bench merge: combine the folders of one study into one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.helpers.console import print_line


def command(
    folders: Annotated[
        list[Path],
        typer.Argument(metavar="FOLDER", help="Folders of one study, such as its shards."),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write: a new one, or one to add to.")],
) -> None:
    """Combine the trials of one study that different machines made.

    A trial that several folders have must be identical in all of them; a finished trial replaces a failed one.
    """
    from bench.storage.merge import merge

    merged = merge(folders, output)
    print_line(f"{merged.rows} trials in {output}: {merged.added} added, {merged.same} held by more than one folder")
