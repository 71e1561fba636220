"""bench status: print the progress, failures and environments of a study's folder, also while a run writes to it."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from time import sleep
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from bench.cli.console import StudyFolder, table, too_early
from bench.helpers.console import duration, print_line
from bench.helpers.parsing import JsonObject
from bench.helpers.text import count, listed
from bench.plugins.inputs import shown
from bench.study.cell import read
from bench.trial.columns import Row

if TYPE_CHECKING:
    from bench.storage.folder import Folder

SHOWN = 20  # lines of failures


def command(
    path: StudyFolder,
    watch: Annotated[bool, typer.Option("--watch", help="Refresh every two seconds until the run ends.")] = False,
    check: Annotated[bool, typer.Option("--check", help="Compare every stored trial with its digest now.")] = False,
    best: Annotated[bool, typer.Option("--best", help="Print the best point of each problem, and its run.")] = False,
) -> None:
    """Print the progress, failures and environments of a study's folder, also while a run writes to it.

    With --check, the exit code is 1 where a trial is damaged or missing.
    """
    from bench.cli import answer
    from bench.storage.folder import Folder

    console, folder = Console(), Folder(path)
    if watch:
        with Live(summary(folder), console=console, auto_refresh=False) as live:
            while folder.running():
                sleep(2)
                live.update(summary(folder), refresh=True)
        return
    store = folder.store.check() if check else folder.store.check_count()
    console.print(summary(folder))
    if check or not store.sound:
        print_line(f"store: {store.sentence}", None if store.sound else "red", console)
    if not folder.running() and folder.store.held().trials:
        answer.show(folder.path, console)
    if best:
        for line in best_points(folder.path):
            print_line(line, console=console)
    for line, style in _lines(folder):
        print_line(line, style, console)
    if check and not store.sound:
        sys.exit(1)


def best_points(path: Path) -> Iterator[str]:
    """Yield two lines a problem: its best value and the run that found it, and the point, with all digits."""
    from bench.analysis.best import best
    from bench.results.results import StoredResults

    for problem, value, optimizer, trial, point in best(StoredResults(path).frame):
        yield f"{problem}: {value!r} by {optimizer}, trial {trial}"
        yield "  " + ", ".join(f"{name} = {coordinate!r}" for name, coordinate in point.items())


def _lines(folder: Folder) -> Iterator[tuple[str, str | None]]:
    """Yield a line on each check, failure, killed run and environment of a folder, with its colour."""
    from bench.storage.folder import AT_ENDS

    for label, names in folder.changed().items():
        what = listed(list(map(shown, names)), 5)
        yield f"{label} changed since its trials were made ({what}): 'bench run' makes those of it now", "yellow"
    yield from ((line, "red") for line in _failures(folder))
    yield from ((line, "yellow") for line in _killed(folder))
    verified = folder.verification()
    if again := verified.get(AT_ENDS):
        yield again["sentence"], "red" if again["different"] else None
        yield from ((line, "red") for line in again["different"])
    if "verified" in verified:
        line = f"verified {verified['verified']}: {verified.get('sentence')}"
        yield line, "red" if verified.get("different") else None
    made = folder.store.made()
    for number, record in folder.store.records("environments").items():
        yield from ((line, None) for line in (_environment(record, made.get(number, 0)) if record else ()))


def summary(folder: Folder) -> Group:
    """Return a table of finished and failed trials by optimizer, and lines for a run that is under way."""
    from bench.execution.journal import under_way_lines

    study, cells = folder.study(), folder.store.cells()
    planned = len(study.problems) * study.trials
    rows = []
    for entry in study.optimizers:
        its_cells = [cell for cell in cells if cell.optimizer == entry.label]
        done, lost = sum(cell.done for cell in its_cells), sum(cell.failed for cell in its_cells)
        seconds = sum(cell.wall_s for cell in its_cells)  # 0 of imported trials, whose times are unknown
        mean = f"{seconds / done:.3g}" if done and seconds else ""
        rows.append((entry.label, done, Text(str(lost), "red" if lost else ""), planned, mean))
    head = Text(f"study {study.name}" + f": {study.title}" * bool(study.title))
    lines: list[RenderableType] = [head, table(("optimizer", "done", "failed", "of", "s a trial"), rows)]
    if returned := folder.store.undeclared():
        lines.append(Text(too_early(returned), "red"))
    lines += map(Text, _kept(folder))
    if running := folder.running():
        left = planned * len(study.optimizers) - sum(cell.done for cell in cells)
        lines.append(Text(_progress(folder, running, left)))
        lines += map(Text, under_way_lines(folder.path, study.rules.parallel))
    else:
        lines += map(Text, interrupted(folder))
    return Group(*lines)


def interrupted(folder: Folder) -> Iterator[str]:
    """Yield a line on the evaluations that the journals of unfinished trials hold."""
    from bench.execution.journal import FOLDER, journals

    if not (folder.path / FOLDER).is_dir():
        return
    left = {trial.key for trial in folder.study().plan()} - folder.store.keys(finished_only=True)
    found = journals(folder.path, {(problem, optimizer, str(number)) for problem, optimizer, number in left})
    if numbers := [len(records) for _, records in found]:
        noted = f"{count(sum(numbers), 'evaluation')} of {count(len(numbers), 'interrupted trial')}"
        yield f"{noted} are in the journal: 'bench run' goes on from there"


def _kept(folder: Folder) -> Iterator[str]:
    """Yield a line on the trials of each optimizer that the study does not select: earlier versions, and others."""
    held = folder.store.held()
    kept: Counter[str] = Counter()
    for number, cell in held.all.items():
        if number not in held.selected and held.trials[number]:
            kept[cell.optimizer] += held.trials[number]
    every = held.versions
    for label, selected in held.optimizers.items():
        versions = [*every[read(selected)["label"]]]
        parts = [
            f"{count(number, 'trial')} "
            f"({'of other problems, seeds or budgets' if record == selected else f'version {place}'})"
            for place, record in enumerate(versions, start=1)
            if (number := kept.pop(record, 0))
        ]
        if parts:
            place = versions.index(selected) + 1
            yield f"{label}: version {place} of {len(versions)} is selected; also kept: {', '.join(parts)}"
    others: Counter[str] = Counter()
    for record, number in kept.items():
        others[read(record)["label"]] += number
    yield from (f"kept of {label}, which the study does not name: {count(n, 'trial')}" for label, n in others.items())


def _progress(folder: Folder, running: JsonObject, left: int) -> str:
    """Describe the run that is under way: its process, its speed and the time left."""
    text = f"running: process {running['pid']} on {running['host']} since {running['started']}"
    made = folder.store.made()
    cells = [
        number
        for number, record in folder.store.records("environments").items()
        if str(record.get("started")) >= running["started"]
    ]
    finished = sum(made.get(number, 0) for number in cells)
    if not finished:
        return text
    elapsed = (datetime.now(UTC) - datetime.fromisoformat(running["started"])).total_seconds()
    remaining = f", about {duration(elapsed / finished * left)} for the {left} left" if left else ""
    return f"{text}; {count(finished, 'trial')} made, {finished / max(elapsed, 1):.3g} a second{remaining}"


def _failures(folder: Folder) -> list[str]:
    """Return one line for each optimizer and reason of failure, at most ``SHOWN``."""
    reasons: dict[tuple[str, str, str], list[Row]] = {}
    for row in folder.store.rows("status != 'ok'"):
        key = row["status"], row["optimizer"], str(row["error"]).partition("\n")[0]
        reasons.setdefault(key, []).append(row)
    lines = []
    for (status, optimizer, reason), (first, *further) in reasons.items():
        more = f" and {len(further)} more" if further else ""
        lines.append(f"{status}: {optimizer} on {first['problem']}, trial {first['trial']}{more}: {reason}")
    hidden = len(lines) - SHOWN
    return [*lines[:SHOWN], *([f"… and {hidden} more reasons"] if hidden > 0 else [])]


def _killed(folder: Folder) -> Iterator[str]:
    """Yield a line on the last run where it was killed: the trials then under way, one of which may have done it."""
    if (run := folder.killed()) and not folder.running():
        trials = [f"{optimizer} on {problem}, trial {number}" for problem, optimizer, number in run["trials"]]
        yield f"a run was killed at {run['ended']} or later; under way were {'; '.join(trials)}"


def _environment(record: JsonObject, made: int) -> list[str]:
    """Describe one run on one machine in a line, or where imported trials come from; environment.json has the rest."""
    trials = count(made, "trial")
    if source := record.get("imported"):
        licence = record.get("licence") or "licence unknown"
        line = f"imported {record.get('started')}: {trials} from {source} ({record.get('format')}, {licence})"
        return [line, *(f"    left out: {sentence}" for sentence in record.get("left_out", ()))]
    ended = f", ended {record['ended']}" if record.get("ended") else ", not ended"
    where = f"{record.get('host')} ({record.get('backend')}, jobs: {record.get('jobs')})"
    return [f"ran {record.get('started')}{ended}: {trials} on {where}: {record.get('command')}"]
