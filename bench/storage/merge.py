"""Merge the stores of one study that was run on different machines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

from bench.columns import Row
from bench.errors import BenchError
from bench.helpers.text import listed
from bench.storage.folder import DESCRIPTIONS, Folder
from bench.storage.rows import disagreement
from bench.storage.writing import Writer
from bench.study import Study


@dataclass(frozen=True)
class Merged:
    """The numbers of trials in the merged store, of those added, and of those that it held already.

    ``notes`` names, in a sentence for each folder that has any, the damaged trials that were left out.
    """

    rows: int
    added: int
    same: int
    notes: tuple[str, ...] = ()


def merge(folders: Sequence[str | PathLike[str]], output: str | PathLike[str]) -> Merged:
    """Write the trials of all folders into one, with the environments that made them.

    The folders' numbers of trials may differ. The output may hold some of them already: a merge that was interrupted is
    continued by the same call. Every trial is compared with its digest; damaged ones are left out.

    Raises:
        BenchError: when the folders hold different studies, data or code, or a trial with different outcomes, and when
            the output holds damaged trials.
    """
    sources, target = [Folder(path) for path in folders], Folder(output)
    if len({source.path.resolve() for source in sources} | {target.path.resolve()}) < len(sources) + 1:
        raise BenchError("a folder is given twice; give folders that differ, and another one to write")
    study = _common([(source, source.study()) for source in sources])
    with target.lock():
        if not (present := target.store.check(structure=True)).sound:
            raise BenchError(f"{target.path}: {present.sentence}")
        target.claim(study)
        added = same = 0
        notes = []
        with target.store.writer() as writer:
            for source in sources:
                target.refuse_changes(source.fingerprints())
                check = source.check_store()
                with source.store.reader() as reader:
                    new, old = copy(reader.sound(), reader.environments(), writer, str(source.path))
                added, same = added + new, same + old
                if not check.sound:
                    notes.append(f"{source.path}: {check.sentence}")
        target.write_environments()
        if described := {label: about for source in sources for label, about in source.noted(DESCRIPTIONS).items()}:
            target.note(DESCRIPTIONS, described)
        rows = sum(cell.done + cell.failed for cell in target.store.cells())
    return Merged(rows, added, same, tuple(notes))


def _common(studies: list[tuple[Folder, Study]]) -> Study:
    """Return the study of all folders, with the largest number of trials and the controls of all."""
    first, study = studies[0]
    for folder, other in studies[1:]:
        if other.identity() != study.identity():
            how = listed(study.differences(other), between="; ")
            raise BenchError(
                f"{folder.path} holds another study than {first.path} ({how}); only parts of one study can be merged"
            )
        study = study.joined(other)
    return study


def copy(
    rows: Iterable[Row], environments: Mapping[int, Mapping[str, Any]], writer: Writer, name: str
) -> tuple[int, int]:
    """Add the rows of another store, which is called ``name``; return the numbers added and present already.

    Rows refer to an environment only where its record is known.

    Raises:
        BenchError: when a trial has two outcomes.
    """
    numbers = {number: writer.environment(record) for number, record in environments.items() if record}
    added = same = 0
    with writer.transaction():
        for row in rows:
            present = writer.find(row["problem"], row["optimizer"], row["trial"])
            if present is None or (present["status"] != "ok" and row["status"] == "ok"):
                writer.put(row | {"environment": numbers.get(row["environment"])})
                added += 1
            else:
                same += 1
                if row["status"] == "ok" and (different := disagreement(present, row)):
                    raise BenchError(
                        f"trial {row['trial']} of {row['optimizer']} on {row['problem']} has another {different} in "
                        f"{name} than in the folders before it, though both were made from one seed; find out "
                        "which is right ('bench verify') and remove the other ('bench rm')"
                    )
    return added, same
