"""bench rm: remove trials from a study's folder."""

from __future__ import annotations

from typing import Annotated

import typer

from bench.cli.console import StudyFolder
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError, nearest


def command(
    path: StudyFolder,
    optimizer: Annotated[
        list[str] | None,
        typer.Option(help="Remove the trials of this optimizer; repeatable."),
    ] = None,
    problem: Annotated[
        list[str] | None,
        typer.Option(help="Remove the trials on this problem; repeatable."),
    ] = None,
    failed: Annotated[bool, typer.Option("--failed", help="Remove only trials that failed or timed out.")] = False,
    old: Annotated[
        bool, typer.Option("--old", help="Remove the trials that the study no longer selects, as of earlier versions.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print how many trials would be removed, and remove none.")
    ] = False,
) -> None:
    """Remove trials from a study's folder; the next run makes them again."""
    from bench.storage.folder import Folder

    folder = Folder(path)
    folder.study()  # refuses one that was changed
    if not (optimizer or problem or failed or old):
        raise BenchError("name what to remove: --optimizer NAME, --problem NAME, both for one cell, --failed or --old")
    held = folder.store.held()
    labels = {
        number: held.selected.get(number, cell.labels)
        for number, cell in held.all.items()
        if (number not in held.selected) == old
    }
    kept = {label for cell in held.all.values() for label in cell.labels}
    wanted = [
        _labels(names, sorted({pair[place] for pair in labels.values()}), kind, kept)
        for place, (names, kind) in enumerate(((problem, "problem"), (optimizer, "optimizer")))
    ]
    cells = {number: pair for number, pair in labels.items() if pair[0] in wanted[0] and pair[1] in wanted[1]}
    if dry_run:
        counts = folder.store.cells(cells)
        print_line(
            f"{sum(cell.failed if failed else cell.failed + cell.done for cell in counts)} trials would be removed"
        )
        return
    with folder.lock(), folder.store.writer() as writer:
        count = writer.remove(cells, failed_only=failed)
    again = "" if old else "; 'bench run' into this folder makes them again"
    print_line(f"{count} trials removed{again}")


def _labels(wanted: list[str] | None, labels: list[str], kind: str, kept: set[str]) -> list[str]:
    """Return the labels asked for, or all of them where none is given."""
    for label in wanted or []:
        if label not in labels:
            old = "; --old removes what the folder keeps of it" if label in kept else nearest(label, labels)
            raise BenchError(f"the study has no {kind} {label!r}{old}")
    return wanted or labels
