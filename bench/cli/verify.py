"""bench verify: make stored trials again and compare them bit by bit."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.cli.console import StudyFolder, Untrusted, checked_jobs
from bench.helpers.console import print_error, print_line, steps


def command(
    folder: StudyFolder,
    trials: Annotated[int, typer.Option(help="Trials of each cell to make again.")] = 2,
    jobs: Annotated[
        int | None,
        typer.Option(callback=checked_jobs, help="Trials made at a time; default: a number other than the run's."),
    ] = None,
    untrusted: Untrusted = False,
) -> None:
    """Make some trials of each cell again and compare them with the stored ones, bit by bit.

    They are made with another number of workers and another PYTHONHASHSEED, one of each optimizer both first and last,
    so that an optimizer that learns from trial to trial is found out. Where processes fork (Linux), the problem is in
    another process than the optimizer, so that one that overspends its budget or gets values by another way than the
    objective is found out, too. Every stored trial is also compared with the digest that
    was stored with it. The outcome is noted in the folder for the report. The exit code is 1 where a trial differs or
    is damaged.
    """
    if not verify_folder(folder, Console(), trials=trials, jobs=jobs, untrusted=untrusted):
        sys.exit(1)


def verify_folder(path: Path, console: Console, *, trials: int, jobs: int | None = None, untrusted: bool) -> bool:
    """Make trials of each cell of a folder again and print the outcome; return whether all is as it was stored."""
    from bench.execution.verify import verify as make_again

    with steps(console, "verify") as on_progress:
        outcomes = make_again(path, trials=trials, n_jobs=jobs, untrusted=untrusted, on_progress=on_progress)
    for line in outcomes.lines():
        print_line(line, "red", console)
    print_line(outcomes.sentence, console=console)
    print_line(outcomes.stored, console=console)
    if outcomes.different:
        print_error("some trials are not repeated bit by bit")
    return not outcomes.different
