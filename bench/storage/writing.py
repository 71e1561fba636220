"""Write the rows of a store."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.plugins.inputs import Inputs
from bench.storage import committed
from bench.storage.cells import Cells, read, record_digest, selection_digest, split
from bench.storage.committed import Committed
from bench.storage.rows import NAMES, VALUES, binding, digest, typed
from bench.study.cell import Cell, Labels
from bench.trial.columns import Row
from bench.trial.trial import Trial

_INTO = ("cell", "trial", "digest", "names", *VALUES)
_INSERT = f"INSERT INTO results ({', '.join(_INTO)}) VALUES ({', '.join('?' * len(_INTO))})"
_TWICE = "SQLITE_CONSTRAINT_PRIMARYKEY", "SQLITE_CONSTRAINT_UNIQUE"  # of a row that is there already


class Writer:
    """The only writer of an open store: adds and removes rows.

    Args:
        connection: to the store.
        path: of the store.
    """

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        self._connection, self.path = connection, path
        self._file = _identity(path)
        self._committed, self._more = Committed(), 0  # what was committed, and rows added since then
        self._inputs: dict[str | None, tuple[int | None, list[Inputs]]] = {None: (None, [{}, {}])}
        self._selected: dict[Labels, int] = {}
        self.cells = Cells()
        self._read()
        self._note()

    def add(self, trial: Trial, row: Row, environment: int | None = None, made_from: str | None = None) -> list[str]:
        """Commit one trial's row, as :func:`bench.trial.trial.finished` returns it; missing columns are stored as NULL.

        It replaces a failed row of the same trial, but never a finished one. ``made_from`` is the record of its inputs,
        as JSON. Return those that are others than those of the selected cell, in whose place another cell gets the row.
        """
        if made_from not in self._inputs and made_from is not None:
            record = json.loads(made_from)
            self._inputs[made_from] = self.record("inputs", record), split(record)
        number, inputs = self._inputs[made_from]
        selected = self.cells.all[self._selected[trial.key[:2]]]
        others, cell = self.cells.conflicts(selected, inputs), self.cells.fitting(selected, inputs)
        with self.transaction():
            self.put(row | trial.columns | {"environment": environment, "inputs": number}, self.number(cell))
        self.cells.add(cell, inputs)
        return others

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Commit all that is written in this context, or nothing of it.

        Raises:
            BenchError: where another program has removed or replaced the store's file, or writes to it, too.
        """
        try:
            with self._connection:
                yield
                self._committed = Committed(self._committed.commits + 1, self._committed.trials + self._more)
                self._connection.execute("UPDATE committed SET commits = ?, trials = ?", self._committed)
                self._more = 0
        except BaseException as error:
            self._read()  # without the cells and names of rows that were not committed
            if getattr(error, "sqlite_errorname", "") not in _TWICE:
                raise
            raise BenchError(
                f"another run writes to the store {self.path}, as where .lock was removed from its folder; what it "
                "holds is kept: wait for the end of the other run, and run the same command again"
            ) from error
        if _identity(self.path) != self._file:
            raise BenchError(
                f"the store {self.path} was removed or replaced while it was written, and its last trials are lost; "
                "run the same command again to make them"
            )
        self._note()

    def put(self, row: Row, cell: int | None = None) -> None:
        """Add a row as :meth:`bench.storage.store.Store.rows` yields it, within :meth:`transaction`.

        Args:
            row: the columns.
            cell: the number of its cell; by default that which is selected under the labels of the row.

        Raises:
            KeyError: for labels that the study does not select.
            ValueError: for a column that the store does not have.
        """
        values = typed(row)
        texts = [None if row.get(name) is None else str(row[name]) for name in NAMES]
        cell = self._selected[row["problem"], row["optimizer"]] if cell is None else cell
        names = self._id("names", **dict(zip(NAMES, texts, strict=True))) if texts[0] is not None else None
        bound = binding(self.cells.all[cell], [text if text is None else text.encode() for text in texts])
        hashed = [value.encode() if isinstance(value, str) else value for value in values]
        noted = digest(bound, (row["trial"], *hashed))
        replaced = self._connection.execute(
            "DELETE FROM results WHERE cell = ? AND trial = ? AND status != 'ok'", (cell, row["trial"])
        )
        self._connection.execute(_INSERT, (cell, row["trial"], noted, names, *values))
        self._more += 1 - replaced.rowcount

    def find(self, cell: int, trial: int) -> Row | None:
        """Return the columns of one trial but its labels, or None."""
        columns = (*NAMES, *VALUES)
        query = f"SELECT {', '.join(columns)} FROM results LEFT JOIN names ON names.id = names"
        row = self._connection.execute(f"{query} WHERE cell = ? AND trial = ?", (cell, trial)).fetchone()
        return None if row is None else dict(zip(columns, row, strict=True))

    def number(self, cell: Cell) -> int:
        """Return the number of a cell, which is added where it is new, within :meth:`transaction`."""
        problem, optimizer = self._id("problems", record=cell.problem), self._id("optimizers", record=cell.optimizer)
        evaluations, seed = cell.conditions
        number = self._id("cells", problem=problem, optimizer=optimizer, evaluations=evaluations, seed=seed)
        self.cells.all[number] = cell
        return number

    def select(self, identity: str, cells: Mapping[Labels, Cell]) -> None:
        """Commit the cells that a study selects, by label, in place of the previous selection."""
        with self.transaction():
            selected = {self.number(cell): labels for labels, cell in cells.items()}
            self._connection.execute("DELETE FROM selected")
            self._connection.executemany(
                "INSERT INTO selected VALUES (?, ?, ?)", [(number, *labels) for number, labels in selected.items()]
            )
            self._connection.execute("DELETE FROM study")
            values = identity, selection_digest(identity, selected)
            self._connection.execute("INSERT INTO study VALUES (?, ?)", values)
        self._read()

    def record(self, table: str, record: JsonObject) -> int:
        """Commit a record of environments, inputs or history, and return its number; equal records have one number."""
        text = json.dumps(record)
        if (number := self._known(table, record=text)) is None:
            with self.transaction():
                number = self._id(table, record=text)
                self._set_record(table, number, text)
        return number

    def change(self, number: int, record: JsonObject) -> None:
        """Commit a changed record of an environment."""
        with self.transaction():
            self._set_record("environments", number, json.dumps(record))

    def _known(self, table: str, **values: Any) -> int | None:
        """Return the number of the row that has these values."""
        condition = " AND ".join(f"{name} = :{name}" for name in values)
        found = self._connection.execute(f"SELECT id FROM {table} WHERE {condition}", values).fetchone()
        return None if found is None else int(found[0])

    def _id(self, table: str, **values: Any) -> int:
        """Return the number of the row that has these values, which is added where there is none."""
        if (number := self._known(table, **values)) is None:
            names = f"({', '.join(values)}) VALUES ({', '.join(f':{name}' for name in values)})"
            number = int(self._connection.execute(f"INSERT INTO {table} {names}", values).lastrowid or 0)
        return number

    def remove(self, cells: Iterable[int], *, failed_only: bool = False) -> int:
        """Remove the rows of cells, by their numbers, or only failed rows; return the number of rows."""
        with self.transaction():
            condition = " AND status != 'ok'" if failed_only else ""
            numbers = [(number,) for number in cells]
            done = self._connection.executemany(f"DELETE FROM results WHERE cell = ?{condition}", numbers)
            self._more -= done.rowcount
        return int(done.rowcount)

    def _note(self) -> None:
        committed.write(self.path.parent, self._committed)

    def _set_record(self, table: str, number: int, text: str) -> None:
        values = text, record_digest(number, text.encode()), number
        self._connection.execute(f"UPDATE {table} SET record = ?, digest = ? WHERE id = ?", values)

    def _read(self) -> None:
        """Read the cells, and what was committed."""
        self._more = 0
        self._committed = Committed(*self._connection.execute("SELECT commits, trials FROM committed").fetchone())
        self.cells = read(self._connection)
        self._selected = {labels: number for number, labels in self.cells.selected.items()}


def _identity(path: Path) -> tuple[int, int] | None:
    """Return device and number of a file, which another one in its place has not; None where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino
