"""The cells of an open store, and those that its last study selects, under the labels that the study shows."""

from __future__ import annotations

import sqlite3
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache

from bench.helpers.parsing import JsonObject, parse_json
from bench.plugins.inputs import Inputs, conflicts
from bench.plugins.observing import PARTS
from bench.storage.rows import decoded, digest
from bench.study.cell import Cell, Labels, with_inputs
from bench.study.cell import read as read_record


@dataclass
class Cells:
    """The cells of a store, and those that its last study selects.

    Attributes:
        all: every cell by its number.
        selected: the labels of those that the last study selects, by their number.
        study: the identity of that study (:meth:`bench.study.Study.identity`); "" before the first.
        made: what the trials of a problem or an optimizer were made from, by its record, as far as that is known.
        trials: the number of rows of each cell, by the cell's number, when the store was read.
    """

    all: dict[int, Cell] = field(default_factory=dict)
    selected: dict[int, Labels] = field(default_factory=dict)
    study: str = ""
    made: dict[str, Inputs] = field(default_factory=dict)
    trials: Counter[int] = field(default_factory=Counter)

    @property
    def stored(self) -> Counter[Cell]:
        """The number of rows of each cell that has any, selected or not."""
        return Counter({cell: self.trials[number] for number, cell in self.all.items() if self.trials[number]})

    @property
    def by_labels(self) -> dict[Labels, Cell]:
        """The selected cells by the labels that the study shows."""
        return {labels: self.all[number] for number, labels in self.selected.items() if number in self.all}

    @property
    def optimizers(self) -> dict[str, str]:
        """The records of the selected optimizers, by the label that the study shows."""
        return {labels[1]: cell.optimizer for labels, cell in self.by_labels.items()}

    @property
    def versions(self) -> dict[str, dict[str, list[int]]]:
        """The versions of each optimizer, by the label and then the text of its record, with the numbers of its cells.

        An optimizer whose name, options or inputs changed is another version; the first one comes first. One whose
        trials were removed keeps its place, so a number goes on meaning the same.
        """
        versions: dict[str, dict[str, list[int]]] = {}
        for number, cell in sorted(self.all.items()):
            label = read_record(cell.optimizer)["label"]
            versions.setdefault(label, {}).setdefault(cell.optimizer, []).append(number)
        return versions

    def add(self, cell: Cell, inputs: Sequence[Inputs]) -> None:
        """Take note of what trials of a cell were made from, by the records of its problem and its optimizer."""
        for text, read_by_it in zip(cell.records, inputs, strict=True):
            self.made.setdefault(text, {}).update(read_by_it)

    def made_from(self, cell: Cell) -> list[Inputs]:
        """Return what trials of a cell's problem and of its optimizer were made from."""
        return [self.made.get(text, {}) for text in cell.records]

    def conflicts(self, cell: Cell, inputs: Sequence[Inputs]) -> list[str]:
        """Return the names of these inputs that are others than those that trials of a cell were made from."""
        return [name for pair in zip(self.made_from(cell), inputs, strict=True) for name in conflicts(*pair)]

    def fitting(self, cell: Cell, inputs: Sequence[Inputs]) -> Cell:
        """Return the cell to which trials of a cell belong that were made from these inputs.

        That is the first whose trials were made from no other state of any of them: the cell itself, the latest one, or
        one with the next numbers.
        """
        records = []
        for place, (text, read_by_it) in enumerate(zip(cell.records, inputs, strict=True)):
            known = text, *self.candidates(place, text)
            records.append(next(each for each in known if not conflicts(self.made.get(each, {}), read_by_it)))
        return Cell(records[0], records[1], *cell.conditions)

    def candidates(self, place: int, text: str) -> list[str]:
        """Return the records of this problem (place 0) or optimizer (1), the latest inputs first; last, one of new."""
        records = {cell.records[place] for cell in self.all.values()}
        numbers = {read_record(each)["inputs"] for each in records if with_inputs(each, 1) == with_inputs(text, 1)}
        return [with_inputs(text, number) for number in (*sorted(numbers, reverse=True), max(numbers, default=0) + 1)]


def read(connection: sqlite3.Connection) -> Cells:
    """Return the cells of a store.

    Raises:
        sqlite3.DatabaseError: where they cannot be read, or the selection is not as it was written.
    """
    text = cache(decoded)  # a record is one object, however many cells have it
    joined = "cells JOIN problems ON problems.id = problem JOIN optimizers ON optimizers.id = optimizer"
    columns = "cells.id, problems.record, optimizers.record, evaluations, seed"
    every = connection.execute(f"SELECT {columns} FROM {joined} ORDER BY cells.id")
    cells = Cells({number: Cell(text(p), text(o), *rest) for number, p, o, *rest in every}, *_selected(connection))
    records = records_of(connection, "inputs")
    for cell, number, rows in connection.execute("SELECT cell, inputs, count(*) FROM results GROUP BY cell, inputs"):
        cells.trials[cell] += rows
        if cell in cells.all:
            cells.add(cells.all[cell], split(records.get(number, {})))
    return cells


def _selected(connection: sqlite3.Connection) -> tuple[dict[int, Labels], str]:
    studies = connection.execute("SELECT identity, digest FROM study").fetchall()
    identity, noted = studies[0] if len(studies) == 1 else (b"", None)
    text = cache(decoded)  # a label is one object, however many cells have it
    selected = connection.execute("SELECT cell, problem, optimizer FROM selected ORDER BY cell")
    labelled = {number: (text(problem), text(optimizer)) for number, problem, optimizer in selected}
    if (labelled or studies) and selection_digest(decoded(identity), labelled) != noted:
        error = sqlite3.DatabaseError("the selection of cells is not as it was written")
        error.sqlite_errorcode = sqlite3.SQLITE_CORRUPT
        raise error
    return labelled, decoded(identity)


def split(record: JsonObject) -> list[Inputs]:
    """Return the inputs of problem and optimizer from a store's record; of a damaged one nothing is known."""
    parts = [record.get(part) for part in PARTS]
    return [
        {str(name): (str(state), known) for name, (state, known) in part.items()} if isinstance(part, dict) else {}
        for part in parts
    ]


def record_digest(number: int, record: bytes) -> bytes:
    """Return the digest of a record of environments, inputs or history, whose JSON text is given as UTF-8."""
    return digest(b"", (number, record))


def records_of(connection: sqlite3.Connection, table: str) -> dict[int, JsonObject]:
    """Return the records of environments, inputs or history by number, oldest first; a damaged one is empty."""
    found: dict[int, JsonObject] = {}
    for number, text, noted in connection.execute(f"SELECT id, CAST(record AS BLOB), digest FROM {table} ORDER BY id"):
        found[number] = {}
        with suppress(ValueError, TypeError):
            if record_digest(number, text) == noted and isinstance(record := parse_json(text), dict):
                found[number] = record
    return found


def selection_digest(identity: str, selected: Mapping[int, Labels]) -> bytes:
    """Return the digest of a study's identity and of what it selects."""
    parts = (part for number in sorted(selected) for part in (number, *selected[number]))
    return digest(b"", (identity, *parts))
