"""Take trials of equal cells from other folders: to merge the parts of a study, or to reuse what was run elsewhere."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike

from bench.helpers.errors import BenchError
from bench.helpers.text import count, listed
from bench.plugins.inputs import Present, shown
from bench.storage.cells import Cells
from bench.storage.folder import DESCRIPTIONS, Folder
from bench.storage.rows import disagreement
from bench.storage.selection import Selection
from bench.storage.writing import Writer
from bench.study import Study
from bench.study.cell import Cell, Labels, differences
from bench.trial.columns import Row

AnyPath = str | PathLike[str]


@dataclass(frozen=True)
class Merged:
    """The numbers of trials in the merged store, of those added, and of those that it held already."""

    rows: int
    added: int
    same: int


def merge(folders: Sequence[AnyPath], output: AnyPath) -> Merged:
    """Write the trials of all folders into one, with the environments that made them.

    The study is that of the first folder, with the problems and optimizers of all. The folders' numbers of trials may
    differ. The output may hold some of the trials already: a merge that was interrupted is continued by the same call.
    Every trial is compared with its digest.

    Raises:
        BenchError: when a label means different cells in two folders, or one trial has different outcomes, and when a
            folder holds damaged trials.
    """
    sources, target = [Folder(path) for path in folders], Folder(output)
    if len({source.path.resolve() for source in sources} | {target.path.resolve()}) < len(sources) + 1:
        raise BenchError("a folder is given twice; give folders that differ, and another one to write")
    study, cells = _common(sources)
    for source in sources:
        source.require_sound()
    with target.lock():
        target.require_sound()
        target.claim(study, Selection(cells))
        with target.store.writer() as writer:
            added, same = map(sum, zip(*(take(source, writer) for source in sources), strict=True))
        target.write_environments()
        if described := {label: about for source in sources for label, about in source.noted(DESCRIPTIONS).items()}:
            target.note(DESCRIPTIONS, described)
        rows = target.store.held().trials.total()
    return Merged(rows, added, same)


def _common(sources: Sequence[Folder]) -> tuple[Study, dict[Labels, Cell]]:
    """Return the study of all folders, with the largest number of trials, and its cells."""
    studies = [source.study() for source in sources]
    cells, known = dict[Labels, Cell](), Cells()
    for source, study in zip(sources, studies, strict=True):
        held = source.store.held()
        different = study.identity() != studies[0].identity()
        for labels, cell in held.by_labels.items():
            first, theirs = cells.setdefault(labels, cell), held.made_from(cell)
            different = different or first.bare != cell.bare or bool(known.conflicts(first, theirs))
            known.add(first, theirs)
        if different:
            raise BenchError(
                f"{source.path} holds another study than {sources[0].path}, or trials of other code or data; only "
                "parts of one study can be merged: run the study with --reuse to take the trials that it shares with "
                "others"
            )
    return studies[0].override(trials=max(study.trials for study in studies)), cells


@dataclass(frozen=True)
class Reusable:
    """What another folder holds of a study's cells: the study's cells by those of the folder, and a sentence on it."""

    cells: dict[Cell, Cell]
    sentence: str


def reusable(source: Folder, cells: Mapping[Labels, Cell], present: Present) -> Reusable:
    """Return which of these cells another folder holds trials of that were made from what is there now.

    Raises:
        BenchError: where it holds none of them, or a run is writing to it.
    """
    if not source.path.exists():
        raise BenchError(f"{source.path} to be reused does not exist")
    source.study()
    if running := source.running():
        raise BenchError(f"process {running['pid']} is writing to {source.path}; reuse its trials when that has ended")
    check = source.store.check()
    there = source.store.held()
    run = [*there.stored]
    stale = {text: present.changed(there.made.get(text, {})) for cell in run for text in cell.records}
    held = {cell.bare: cell for cell in run if not any(stale[text] for text in cell.records)}
    by_labels = {cell.labels: cell for cell in run}  # the last version of each
    reasons = Counter(_difference(cell, by_labels, stale) for cell in cells.values() if cell.bare not in held)
    others = listed([f"{reason} ({count(number, 'cell')})" for reason, number in reasons.most_common()], between="; ")
    shared = {held[cell.bare]: cell for cell in cells.values() if cell.bare in held}
    sentence = f"{len(shared):,} of the study's {count(len(cells), 'cell')} are in {source.path.name}"
    sentence += f"; of the others {others}" if others else ""
    sentence += "" if check.sound else f"; there {check.sentence}"
    if not shared:
        raise BenchError(f"{sentence}; leave out --reuse {source.path.name}")
    return Reusable(shared, sentence)


def _difference(cell: Cell, there: Mapping[Labels, Cell], stale: Mapping[str, list[str]]) -> str:
    """Return why a cell is none of those of another folder, which are given by their labels."""
    if (other := there.get(cell.labels)) is None:
        known = cell.labels[1] in {optimizer for _, optimizer in there}
        return f"no trial of {cell.labels[1]}" + (" on that problem" if known else "") + " is there"
    parts = [
        f"{key} {getattr(other, key):,}, not {getattr(cell, key):,}"
        for key in ("seed", "evaluations")
        if getattr(other, key) != getattr(cell, key)
    ]
    for label, before, now in zip(cell.labels, other.records, cell.records, strict=True):
        how = [*dict.fromkeys(map(shown, stale[before])), *differences(before, now)]
        parts += [f"{label} is another one ({each})" for each in how]
    return ", ".join(parts)


def take(source: Folder, writer: Writer, wanted: Mapping[Cell, Cell] | None = None, where: str = "") -> tuple[int, int]:
    """Add the sound trials of a folder; return the numbers of those added and of those present already.

    Args:
        source: the folder.
        writer: of the store to add them to.
        wanted: the cells whose trials are taken, each with the cell that they belong to; by default all, which belong
            to where trials were made from the same.
        where: the name of the folder in the environments that are noted here; "" where none is noted.

    Raises:
        BenchError: when a trial has two outcomes.
    """
    mark, counts = {"reused": where} if where else {}, Counter[bool]()
    with source.store.reader() as reader:
        chosen: dict[int, Cell] = {}
        for number, cell in reader.cells.all.items():
            if wanted is None or cell in wanted:
                theirs = reader.cells.made_from(cell)
                chosen[number] = writer.cells.fitting(cell, theirs) if wanted is None else wanted[cell]
                writer.cells.add(chosen[number], theirs)
        made = {environment for number, environment in reader.made_by() if number in chosen}
        environments = {n: each for n, each in reader.records("environments").items() if each and n in made}
        numbers = {
            "environment": {n: writer.record("environments", each | mark) for n, each in environments.items()},
            "inputs": {n: writer.record("inputs", each) for n, each in reader.records("inputs").items() if each},
        }
        for record in reader.records("history").values():
            writer.record("history", record | mark)
        with writer.transaction():
            for number, row in reader.sound():
                if number in chosen:
                    renumbered = {column: known.get(row[column]) for column, known in numbers.items()}
                    counts[_add(row | renumbered, writer.number(chosen[number]), writer, source)] += 1
    return counts[True], counts[False]


def _add(row: Row, number: int, writer: Writer, source: Folder) -> bool:
    """Add a row to the cell of this number unless it holds the trial; return whether it was added.

    Raises:
        BenchError: when the trial has two outcomes.
    """
    present = writer.find(number, row["trial"])
    if present is None or (present["status"] != "ok" and row["status"] == "ok"):
        writer.put(row, number)
        return True
    if row["status"] == "ok" and (different := disagreement(present, row)):
        problem, optimizer = writer.cells.all[number].labels
        raise BenchError(
            f"trial {row['trial']} of {optimizer} on {problem} has another {different} in {source.path} than in "
            f"{writer.path.parent}, though both were made from one seed; find out which is right ('bench verify') and "
            "remove the other ('bench rm')"
        )
    return False
