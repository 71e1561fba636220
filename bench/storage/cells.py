"""The cells of an open store, and those that its last study selects, under the labels that the study shows."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bench.storage.rows import binding, digest
from bench.study.cell import Cell, Labels
from bench.study.cell import read as read_record
from bench.study.looks import Looks


@dataclass
class Cells:
    """What a store holds beside its trials.

    Attributes:
        all: every cell by its number.
        selected: the labels of those that the last study selects, by their number.
        study: the identity of that study (:meth:`bench.study.Study.identity`); "" before the first.
        looks: those that it declared.
    """

    all: dict[int, Cell] = field(default_factory=dict)
    selected: dict[int, Labels] = field(default_factory=dict)
    study: str = ""
    looks: Looks = field(default_factory=Looks)

    @property
    def by_labels(self) -> dict[Labels, Cell]:
        """The selected cells by the labels that the study shows."""
        return {labels: self.all[number] for number, labels in self.selected.items() if number in self.all}

    def versions(self, optimizer: str) -> dict[str, list[int]]:
        """Return the versions of an optimizer that is selected under a label, by record, the first one first.

        Each has the numbers of its cells. An optimizer whose name, options or code changed is another version.
        """
        named = {self.all[number].optimizer for number, labels in self.selected.items() if labels[1] == optimizer}
        labels = {read_record(text)["label"] for text in named}
        versions: dict[str, list[int]] = {}
        for number, cell in sorted(self.all.items()):
            if read_record(cell.optimizer)["label"] in labels:
                versions.setdefault(cell.optimizer, []).append(number)
        return versions

    def shown(self, number: int) -> Labels:
        """Return the labels of a cell for people, whether it is selected or not."""
        if number in self.selected or number not in self.all:
            return self.selected.get(number, UNKNOWN)
        problem, optimizer = self.all[number].labels
        return problem, f"{optimizer} (not selected)"


UNKNOWN = "an unknown problem", "an unknown optimizer"


def read(connection: sqlite3.Connection, *, rescue: bool = False) -> Cells:
    """Return the cells of a store; with ``rescue``, without a selection or all cells where these cannot be read.

    Raises:
        sqlite3.DatabaseError: where they cannot be read, or the selection is not as it was written.
    """
    cells = Cells()
    try:
        cells.all = _all(connection)
        cells.selected, cells.study, cells.looks = _selected(connection)
    except sqlite3.DatabaseError:
        if not rescue:
            raise
    return cells


def _all(connection: sqlite3.Connection) -> dict[int, Cell]:
    rows = connection.execute(
        "SELECT cells.id, problems.record, optimizers.record, evaluations, seed FROM cells"
        " JOIN problems ON problems.id = cells.problem JOIN optimizers ON optimizers.id = cells.optimizer"
    )
    return {number: Cell(_text(problem), _text(optimizer), *rest) for number, problem, optimizer, *rest in rows}


def _selected(connection: sqlite3.Connection) -> tuple[dict[int, Labels], str, Looks]:
    selected = connection.execute("SELECT cell, problem, optimizer FROM selected ORDER BY cell").fetchall()
    studies = connection.execute("SELECT identity, looks, digest FROM study").fetchall()
    identity, looks, noted = studies[0] if len(studies) == 1 else (b"", b"", None)
    labelled = {number: (_text(problem), _text(optimizer)) for number, problem, optimizer in selected}
    if (labelled or studies) and selection_digest(_text(identity), _text(looks), labelled) != noted:
        error = sqlite3.DatabaseError("the selection of cells is not as it was written")
        error.sqlite_errorcode = sqlite3.SQLITE_CORRUPT
        raise error
    return labelled, _text(identity), Looks(json.loads(looks or b"[]"))


def binding_of(cell: Cell, names: Sequence[bytes | None]) -> bytes:
    """Return what the digests of a cell's rows begin with, whose variables and metrics have these names."""
    return binding(*(str(part).encode() for part in cell), *names)


def selection_digest(identity: str, looks: str, selected: Mapping[int, Labels]) -> bytes:
    """Return the digest of a study's identity, of its looks as JSON and of what it selects."""
    parts = (part for number in sorted(selected) for part in (number, *selected[number]))
    return digest(b"", (identity, looks, *parts))


def _text(stored: Any) -> str:
    """Return a text from its UTF-8, which may be damaged."""
    return stored.decode(errors="replace") if isinstance(stored, bytes) else str(stored)
