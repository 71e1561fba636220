"""The cells of an open store, and those that its last study selects, under the labels that the study shows."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from bench.storage.rows import binding, decoded, digest
from bench.study.cell import Cell, Labels
from bench.study.cell import read as read_record


@dataclass
class Cells:
    """The cells of a store, and those that its last study selects.

    Attributes:
        all: every cell by its number.
        selected: the labels of those that the last study selects, by their number.
        study: the identity of that study (:meth:`bench.study.Study.identity`); "" before the first.
    """

    all: dict[int, Cell] = field(default_factory=dict)
    selected: dict[int, Labels] = field(default_factory=dict)
    study: str = ""

    @property
    def by_labels(self) -> dict[Labels, Cell]:
        """The selected cells by the labels that the study shows."""
        return {labels: self.all[number] for number, labels in self.selected.items() if number in self.all}

    @property
    def optimizers(self) -> dict[str, str]:
        """The records of the selected optimizers, by the label that the study shows."""
        return {labels[1]: cell.optimizer for labels, cell in self.by_labels.items()}

    def versions(self, optimizer: str) -> dict[str, list[int]]:
        """Return the versions of an optimizer that is selected under a label; see :meth:`versions_of`."""
        record = self.optimizers.get(optimizer)
        return self.versions_of(record) if record is not None else {}

    def versions_of(self, record: str) -> dict[str, list[int]]:
        """Return the versions of an optimizer, by record, the first one first, each with the numbers of its cells.

        An optimizer whose name, options or code changed is another version. One whose trials were removed keeps its
        place, so a number goes on meaning the same.
        """
        label = read_record(record)["label"]
        versions: dict[str, list[int]] = {}
        for number, cell in sorted(self.all.items()):
            if read_record(cell.optimizer)["label"] == label:
                versions.setdefault(cell.optimizer, []).append(number)
        return versions

    def display_labels(self, number: int) -> Labels:
        """Return the labels of a cell for people, whether it is selected or not."""
        if number in self.selected or number not in self.all:
            return self.selected.get(number, UNKNOWN)
        problem, optimizer = self.all[number].labels
        return problem, f"{optimizer} (not selected)"


UNKNOWN = "an unknown problem", "an unknown optimizer"


def read(connection: sqlite3.Connection) -> Cells:
    """Return the cells of a store.

    Raises:
        sqlite3.DatabaseError: where they cannot be read, or the selection is not as it was written.
    """
    return Cells(_all(connection), *_selected(connection))


def _all(connection: sqlite3.Connection) -> dict[int, Cell]:
    rows = connection.execute(
        "SELECT cells.id, problems.record, optimizers.record, evaluations, seed FROM cells"
        " JOIN problems ON problems.id = cells.problem JOIN optimizers ON optimizers.id = cells.optimizer"
    )
    return {number: Cell(decoded(problem), decoded(optimizer), *rest) for number, problem, optimizer, *rest in rows}


def _selected(connection: sqlite3.Connection) -> tuple[dict[int, Labels], str]:
    selected = connection.execute("SELECT cell, problem, optimizer FROM selected ORDER BY cell").fetchall()
    studies = connection.execute("SELECT identity, looks, digest FROM study").fetchall()
    identity, looks, noted = studies[0] if len(studies) == 1 else (b"", b"", None)
    labelled = {number: (decoded(problem), decoded(optimizer)) for number, problem, optimizer in selected}
    if (labelled or studies) and selection_digest(decoded(identity), decoded(looks), labelled) != noted:
        error = sqlite3.DatabaseError("the selection of cells is not as it was written")
        error.sqlite_errorcode = sqlite3.SQLITE_CORRUPT
        raise error
    return labelled, decoded(identity)


def binding_of(cell: Cell, names: Sequence[bytes | None]) -> bytes:
    """Return the hash that begins the digests of a cell's rows whose variables and metrics have these names."""
    return binding(*(str(part).encode() for part in cell), *names)


def selection_digest(identity: str, looks: str, selected: Mapping[int, Labels]) -> bytes:
    """Return the digest of a study's identity, of a second column and of what it selects."""
    parts = (part for number in sorted(selected) for part in (number, *selected[number]))
    return digest(b"", (identity, looks, *parts))
