"""bench merge: unite the folders of one study."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bench.cli.console import print_line


def merge(
    folders: Annotated[list[Path], typer.Argument(metavar="OUTPUT…", help="Folders of one study, such as shards.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder to write; a new one, or one to add to.")],
) -> None:
    """Unite the trials of one study that were made on different machines.

    A trial that several folders hold must be the same in all of them; where one failed, the finished one is taken.
    """
    from bench.storage.merge import merge as merge_folders

    merged = merge_folders(folders, output)
    print_line(f"{merged.rows} trials in {output}: {merged.added} added, {merged.same} held by more than one folder")
