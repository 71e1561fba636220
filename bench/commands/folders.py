"""Commands for the folders that runs write: status, verify, merge and rm."""

from __future__ import annotations

import sys
from pathlib import Path
from time import sleep
from typing import Annotated

import typer
from rich.console import Console
from rich.live import Live

from bench.commands.says import Output, say
from bench.errors import BenchError, nearest


def status(
    output: Output,
    watch: Annotated[bool, typer.Option("--watch", help="Show it anew every two seconds until the run ends.")] = False,
) -> None:
    """Show how far a study's folder is, what failed, and where it ran; also while a run writes to it."""
    from bench.folder import Folder
    from bench.status import show_status, summary

    console, folder = Console(), Folder(output)
    if watch:
        with Live(summary(folder), console=console, auto_refresh=False) as live:
            while folder.running():
                sleep(2)
                live.update(summary(folder), refresh=True)
        return
    show_status(folder, console)


def verify(
    output: Output,
    trials: Annotated[int, typer.Option(help="Trials of each cell to make again.")] = 2,
    jobs: Annotated[int | None, typer.Option(help="Worker processes; default: another number than the run's.")] = None,
) -> None:
    """Make some trials of each cell again, and compare them with the stored ones bit by bit.

    They are made by another number of workers and with another PYTHONHASHSEED. What is found is noted in the folder,
    for the report. Ends with 1 where a trial is not repeated.
    """
    from bench.progress import steps
    from bench.verify import verify as verify_folder

    console = Console()
    with steps(console, "verify") as on_progress:
        found = verify_folder(output, trials=trials, n_jobs=jobs, on_progress=on_progress)
    for line in found.lines():
        console.print(line, markup=False, highlight=False, soft_wrap=True, style="red")
    console.print(found.sentence, markup=False, highlight=False, soft_wrap=True)
    if found.different:
        say("not every trial is repeated bit by bit")
        sys.exit(1)


def merge(
    folders: Annotated[list[Path], typer.Argument(metavar="OUTPUT…", help="Folders of one study, such as shards.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder to write; a new one, or one to add to.")],
) -> None:
    """Unite the trials of one study that were made on different machines.

    A trial that several folders hold must be the same in all of them; where one failed, the finished one is taken.
    """
    from bench.merge import merge as merge_folders

    merged = merge_folders(folders, output)
    Console().print(
        f"{merged.rows} trials in {output}: {merged.added} added, {merged.same} held by more than one folder",
        markup=False, highlight=False, soft_wrap=True,
    )  # fmt: skip


def remove(
    output: Output,
    optimizer: Annotated[list[str] | None, typer.Option(help="Of this optimizer; repeatable.")] = None,
    problem: Annotated[list[str] | None, typer.Option(help="On this problem; repeatable.")] = None,
    failed: Annotated[bool, typer.Option("--failed", help="Only those that failed or ran out of time.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say how many they are.")] = False,
) -> None:
    """Remove trials from a study's folder, so that the next run makes them again."""
    from bench.folder import Folder

    folder = Folder(output)
    study = folder.study()
    if not (optimizer or problem or failed):
        raise BenchError("say what to remove: --optimizer NAME, --problem NAME, both for one cell, or --failed")
    chosen = [
        _labels(wanted, [entry.label for entry in entries], kind)
        for wanted, entries, kind in ((problem, study.problems, "problem"), (optimizer, study.optimizers, "optimizer"))
    ]
    console = Console()
    if dry_run:
        cells = [cell for cell in folder.store.cells() if cell.problem in chosen[0] and cell.optimizer in chosen[1]]
        count = sum(cell.lost if failed else cell.lost + cell.done for cell in cells)
        console.print(f"{count} trials would be removed", highlight=False)
        return
    with folder.lock(), folder.store.writer() as writer:
        count = writer.remove(*chosen, lost_only=failed)
    console.print(f"{count} trials removed; 'bench run' into this folder makes them again", highlight=False)


def _labels(wanted: list[str] | None, known: list[str], kind: str) -> list[str]:
    """Return the labels asked for, all of them where none is."""
    for label in wanted or []:
        if label not in known:
            raise BenchError(f"the study has no {kind} {label!r}{nearest(label, known)}")
    return wanted or known
