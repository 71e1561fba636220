"""bench reproduce: read a published table critically, run its protocol again, and judge every cell."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.helpers.console import print_line
from bench.helpers.text import count


def command(
    table: Annotated[
        Path,
        typer.Argument(
            help="A table as papers print it (CSV or TOML), with the columns suite, function, dimension, budget, runs, "
            "optimizer, mean and sd, or a column an optimizer."
        ),
    ],
    read_only: Annotated[
        bool, typer.Option("--read-only", help="Only read the table critically; nothing is run.")
    ] = False,
) -> None:
    """Read a published table critically, run its protocol again, and judge every cell.

    Reading finds what no runs can have given: values below the optimum, a best above the mean, an SD that the mean and
    the best exclude, ranks and averages that do not recompute, digits that so many counts cannot have.
    """
    from bench.reproduce.criticism import criticise
    from bench.reproduce.table import read

    console = Console()
    paper = read(table)
    remarks, notes = criticise(paper)
    for note in (*paper.notes, *notes):
        print_line(f"note: {note}", "yellow", console)
    for remark in remarks:
        print_line(f"{remark.where}: {remark.sentence}", console=console)
    wrong = len({remark.where for remark in remarks})
    cells = count(len(paper.cells), "cell")
    print_line(
        f"{wrong} of {cells} contradict themselves, each other or the problem"
        if wrong
        else f"no contradiction in {cells}",
        console=console,
    )
    if read_only and remarks:
        sys.exit(1)
