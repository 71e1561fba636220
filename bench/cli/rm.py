"""bench rm: remove trials from a study's folder."""

from __future__ import annotations

from typing import Annotated

import typer

from bench.cli import completion
from bench.cli.console import Output
from bench.errors import BenchError, nearest
from bench.helpers.console import print_line


def command(
    output: Output,
    optimizer: Annotated[
        list[str] | None,
        typer.Option(help="Remove the trials of this optimizer; repeatable.", autocompletion=completion.optimizers),
    ] = None,
    problem: Annotated[
        list[str] | None,
        typer.Option(help="Remove the trials on this problem; repeatable.", autocompletion=completion.problems),
    ] = None,
    failed: Annotated[bool, typer.Option("--failed", help="Remove only trials that failed or timed out.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print how many trials would be removed, and remove none.")
    ] = False,
) -> None:
    """Remove trials from a study's folder; the next run makes them again."""
    from bench.storage.folder import Folder

    folder = Folder(output)
    study = folder.study()
    if not (optimizer or problem or failed):
        raise BenchError("name what to remove: --optimizer NAME, --problem NAME, both for one cell, or --failed")
    chosen = [
        _labels(wanted, [entry.label for entry in entries], kind)
        for wanted, entries, kind in (
            (problem, study.problems, "problem"),
            (optimizer, study.with_controls, "optimizer"),
        )
    ]
    if dry_run:
        cells = [cell for cell in folder.store.cells() if cell.problem in chosen[0] and cell.optimizer in chosen[1]]
        count = sum(cell.failed if failed else cell.failed + cell.done for cell in cells)
        print_line(f"{count} trials would be removed")
        return
    with folder.lock(), folder.store.writer() as writer:
        count = writer.remove(*chosen, failed_only=failed)
    print_line(f"{count} trials removed; 'bench run' into this folder makes them again")


def _labels(wanted: list[str] | None, labels: list[str], kind: str) -> list[str]:
    """Return the labels asked for, or all of them where none is given."""
    for label in wanted or []:
        if label not in labels:
            raise BenchError(f"the study has no {kind} {label!r}{nearest(label, labels)}")
    return wanted or labels
