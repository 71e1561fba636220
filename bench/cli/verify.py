"""bench verify: make stored trials again and compare them bit by bit."""

from __future__ import annotations

import sys
from typing import Annotated

import typer
from rich.console import Console

from bench.cli.console import Output, print_error, print_line


def verify(
    output: Output,
    trials: Annotated[int, typer.Option(help="Trials of each cell to make again.")] = 2,
    jobs: Annotated[int | None, typer.Option(help="Worker processes; default: a number other than the run's.")] = None,
) -> None:
    """Make some trials of each cell again and compare them with the stored ones, bit by bit.

    They are made with another number of workers and another PYTHONHASHSEED. The outcome is noted in the folder for the
    report. The exit code is 1 where a trial differs.
    """
    from bench.cli.progress import steps
    from bench.execution.verify import verify as verify_folder

    console = Console()
    with steps(console, "verify") as on_progress:
        found = verify_folder(output, trials=trials, n_jobs=jobs, on_progress=on_progress)
    for line in found.lines():
        print_line(line, "red", console)
    print_line(found.sentence, console=console)
    if found.different:
        print_error("some trials are not repeated bit by bit")
        sys.exit(1)
