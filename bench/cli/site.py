"""bench site: a board over many archives of results."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.helpers.console import print_error, print_line, steps
from bench.helpers.text import count


def command(
    archives: Annotated[list[Path], typer.Argument(metavar="ARCHIVE…", help="Archives that 'bench pack' wrote.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder to write.")],
    verify: Annotated[
        int, typer.Option(metavar="K", min=0, help="Trials of each archive to make again, in a sandbox of bubblewrap.")
    ] = 0,
    keep_going: Annotated[
        bool, typer.Option("--keep-going", help="Leave out archives that are refused, and write the rest.")
    ] = False,
) -> None:
    """Write a board: a static site that ranks the optimizers of many archives, where they may be compared.

    Every archive is unpacked and compared with its checksums and digests; one that was changed is refused by name. A
    table has the optimizers that ran the same problems with the same budget, and each row says where it comes from.
    The same archives give the same bytes. With --verify, trials
    of each archive are made again, and the board marks those that differ and those that cannot be made here. The exit
    code is 1 where archives were left out or a trial differs.
    """
    from bench.board import write_board

    with steps(Console(), "read") as on_progress:
        board = write_board(archives, output, verify=verify, keep_going=keep_going, on_progress=on_progress)
    for sentence in board.refused:
        print_error(sentence)
    different = [
        f"{archive.name}: {outcome.trial} {outcome.sentence}"
        for archive in board.archives
        for outcome in archive.again
        if outcome.different
    ]
    for line in different:
        print_line(f"different: {line}", "red")
    print_line(f"{count(len(board.archives), 'archive')}: {board.page}")
    if board.refused or different:
        sys.exit(1)
