"""Bring a store of an older layout to this one, step by step, whole or not at all.

A step reads the tables of one layout and writes those of the next. A new layout adds its step to :data:`STEPS`, with
the schema that it replaces.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from filelock import FileLock, Timeout

from bench.errors import BenchError
from bench.helpers.parsing import parse_json
from bench.plugins import from_file
from bench.plugins.loading import is_imported
from bench.storage.cells import binding_of, selection_digest
from bench.storage.rows import VALUES, binding, decoded, digest
from bench.storage.schema import SCHEMA, create, layout
from bench.study import Entry, Study
from bench.study.cell import Cell, Labels, record

LOCK = ".lock"
"""The file that a run locks in its folder."""

Rows = Iterable[Sequence[Any]]
Put = Callable[[str, str, Rows], None]
"""Adds rows to a table of the next layout: its name, the names of the columns, and the rows; texts are UTF-8."""


class Step(NamedTuple):
    """A step from one layout to the next.

    Attributes:
        schema: of the older layout, as its version wrote it.
        move: fills the tables of the next layout.
    """

    schema: str
    move: Callable[[Older, Put], None]


@dataclass(frozen=True)
class Older:
    """The tables of a store of an older layout, of which damage may have taken some.

    Attributes:
        connection: to the store.
        folder: of the store.
        prefix: what stands before the names of its tables.
    """

    connection: sqlite3.Connection
    folder: Path
    prefix: str = ""

    def move(self, put: Put, *tables: str) -> None:
        """Add all rows of tables that the next layout has, too; another program may have dropped one."""
        for table in tables:
            named = self.connection.execute("SELECT 1 FROM sqlite_master WHERE name = ?", (f"{self.prefix}{table}",))
            if named.fetchone():
                rows = self.connection.execute(f"SELECT * FROM {self.prefix}{table}")
                put(table, ", ".join(str(name) for name, *_ in rows.description), rows)

    def texts(self, table: str) -> dict[Any, list[Any]]:
        """Return the texts of cells or names by their number."""
        return {number: texts for number, *texts in self.connection.execute(f"SELECT * FROM {self.prefix}{table}")}

    def results(self, columns: str) -> Iterator[tuple[Any, ...]]:
        """Return some columns of the trials, cell by cell."""
        return self.connection.execute(f"SELECT {columns} FROM {self.prefix}results ORDER BY cell, trial")


@contextmanager
def current(connection: sqlite3.Connection, path: Path, *, writing: bool) -> Iterator[sqlite3.Connection]:
    """Yield a connection to an open store in this layout: itself, brought to it where need be, or a temporary copy.

    A store is read from a copy where it cannot be written, and while a run writes to its folder.

    Args:
        connection: to the store.
        path: of the store.
        writing: whether it is to be written by whoever has locked its folder; then it is no copy.

    Raises:
        sqlite3.Error: where the store cannot be read, or not be written as it must.
    """
    folder = path.parent
    if writing:
        _migrate(connection, folder)
    if layout(connection) not in STEPS or _migrated(connection, folder):
        yield connection
    else:
        with closing(sqlite3.connect("")) as copy:  # a file that SQLite removes
            with copy:
                _take(Older(connection, folder), int(layout(connection) or 0), copy)
            _migrate(copy, folder)
            yield copy


def _migrated(connection: sqlite3.Connection, folder: Path) -> bool:
    """Bring the open store of a folder to this layout where no run writes there; return whether that was possible."""
    with suppress(OSError, NotImplementedError, Timeout, sqlite3.OperationalError):  # such as a disk that is full
        if os.access(folder, os.W_OK):
            with FileLock(folder / LOCK, timeout=0):
                _migrate(connection, folder)
                return True
    return False


def _migrate(connection: sqlite3.Connection, folder: Path) -> None:
    """Bring an open store to this layout, in one transaction; a kill leaves the older store or the new one."""
    if layout(connection) not in STEPS:
        return
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        while (version := layout(connection)) in STEPS:  # another process may have been first
            query = "SELECT name FROM sqlite_master WHERE type = 'table'"
            tables = [name for (name,) in connection.execute(query).fetchall()]
            connection.execute("DROP VIEW IF EXISTS trials")
            for table in tables:
                connection.execute(f"ALTER TABLE {table} RENAME TO old_{table}")
            _take(Older(connection, folder, "old_"), version, connection)
            for table in tables:
                connection.execute(f"DROP TABLE old_{table}")
    with suppress(sqlite3.OperationalError):
        connection.execute("VACUUM")  # else the file keeps the space of the older tables


def _take(older: Older, version: int, target: sqlite3.Connection) -> None:
    """Make the tables of the layout after ``version``, and fill them."""
    create(target, STEPS[version + 1].schema if version + 1 in STEPS else SCHEMA)

    def put(table: str, columns: str, rows: Rows) -> None:
        query = "SELECT CAST(name AS BLOB) FROM pragma_table_info(?) WHERE type = 'TEXT'"
        texts = {name.decode() for (name,) in target.execute(query, (table,)).fetchall()}
        values = ["CAST(? AS TEXT)" if name in texts else "?" for name in columns.split(", ")]
        target.executemany(f"INSERT OR IGNORE INTO {table} ({columns}) VALUES ({', '.join(values)})", rows)

    older.connection.text_factory = bytes  # damage may leave texts that are no UTF-8
    STEPS[version].move(older, put)
    older.connection.text_factory = str


# from layout 3, in which trials had no calls, and cells were labels

_VALUES_3 = (
    "environment", "seed", "status", "fun", "nfev", "wall_s", "cpu_s", "objective_s", "stop", "outside_box", "error",
    "x", "metrics", "trace",
)  # fmt: skip

_SCHEMA_3 = """
CREATE TABLE committed (commits INTEGER NOT NULL, trials INTEGER NOT NULL);
CREATE TABLE environments (id INTEGER PRIMARY KEY, record TEXT NOT NULL, digest BLOB);
CREATE TABLE cells (
    id INTEGER PRIMARY KEY, problem TEXT NOT NULL, optimizer TEXT NOT NULL, UNIQUE (problem, optimizer)
);
CREATE TABLE names (
    id INTEGER PRIMARY KEY, variables TEXT NOT NULL, metric_names TEXT NOT NULL, UNIQUE (variables, metric_names)
);
CREATE TABLE results (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, digest BLOB, names INTEGER REFERENCES names,
    environment INTEGER REFERENCES environments, seed INTEGER, status TEXT NOT NULL, fun REAL, nfev INTEGER,
    wall_s REAL, cpu_s REAL, objective_s REAL, stop TEXT, outside_box INTEGER, error TEXT, x BLOB, metrics BLOB,
    trace BLOB, PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE VIEW trials AS
    SELECT problem, optimizer, trial, environment, seed, status, fun, nfev, wall_s, cpu_s, objective_s, stop, \
outside_box, error, variables, x, metric_names, metrics, trace
    FROM results JOIN cells ON cells.id = cell LEFT JOIN names ON names.id = results.names;
PRAGMA user_version = 3
"""


def _from_3(older: Older, put: Put) -> None:
    """Fill the tables of layout 4; a row that does not fit its digest gets none, and stays damaged."""
    older.move(put, "committed", "environments", "names")
    labels = older.texts("cells")
    cells, selected, study = _cells_3(
        older, {number: (decoded(one), decoded(two)) for number, (one, two) in labels.items()}
    )
    places: list[dict[str, int]] = [{}, {}]
    for place, table in enumerate(("problems", "optimizers")):
        for cell in cells.values():
            places[place].setdefault(cell.records[place], len(places[place]) + 1)
        put(table, "id, record", [(number, record) for record, number in places[place].items()])
    rows_of_cells = [
        (number, *(of[text] for of, text in zip(places, cell.records, strict=True)), *cell.conditions)
        for number, cell in cells.items()
    ]
    put("cells", "id, problem, optimizer, evaluations, seed", rows_of_cells)
    if study is not None:
        about = study.identity(), json.dumps(study.looks)
        put("selected", "cell, problem, optimizer", [(number, *labels) for number, labels in selected.items()])
        put("study", "identity, looks, digest", [(*about, selection_digest(*about, selected))])

    bound = {cell: partial(binding, *texts) for cell, texts in labels.items()}
    _move_results(older, put, (_VALUES_3, _VALUES_4), bound, cells)


def _move_results(
    older: Older,
    put: Put,
    values: tuple[Sequence[str], Sequence[str]],
    bound: Mapping[Any, Callable[..., bytes]],
    cells: Mapping[Any, Cell],
) -> None:
    """Fill the results of the next layout; a row that does not fit its digest gets none.

    Args:
        older: the tables of the older layout.
        put: adds rows.
        values: the columns of the older layout and of the next one.
        bound: what the digests of the rows of each cell begin with in the older layout, as a function of two names.
        cells: those of the next layout, by number.
    """
    names, (before, after) = older.texts("names"), values

    def rows() -> Iterator[tuple[Any, ...]]:
        for noted, cell, number, trial, *old in older.results(f"digest, cell, names, trial, {', '.join(before)}"):
            named = names.get(number, (None, None))
            row = dict(zip(before, old, strict=True))
            moved = [row.get(name) for name in after]
            known = cell in bound and (number is None or number in names)
            sound = known and digest(bound[cell](*named), (trial, *old)) == noted
            now = binding_of(cells[cell], named) if sound else b""
            yield cell, trial, digest(now, (trial, *moved)) if sound else None, number, *moved

    put("results", f"cell, trial, digest, names, {', '.join(after)}", rows())


def _cells_3(older: Older, labels: dict[int, Labels]) -> tuple[dict[int, Cell], dict[int, Labels], Study | None]:
    """Return the cells, those that the study beside the store selects, and this study, where it can be read.

    What is not known is null in a record: the code of installed optimizers was not noted, and that of files as a hash
    of their bytes, which is known to have changed where the file has others now.
    """
    study = None
    with suppress(BenchError):
        study = Study.load(older.folder / "study.toml")
    data, code = ({label: value for noted in notes for label, value in noted.items()} for notes in _noted_3(older))
    dimensions: dict[str, int] = {}
    with suppress(sqlite3.DatabaseError):
        sizes = f"SELECT cell, max(length(x)) FROM {older.prefix}results WHERE status = 'ok' GROUP BY cell"
        dimensions = {labels[cell][0]: size // 8 for cell, size in older.connection.execute(sizes) if cell in labels}
    entries = [
        {entry.label: entry for entry in group}
        for group in ((study.problems, study.with_controls) if study else ((), ()))
    ]

    def problem(label: str) -> str:
        entry = entries[0].get(label, Entry(label, label))
        handled = {key: getattr(study, key, None) for key in ("constraints", "on_error")}
        known = data.get(label, "") if label in entries[0] else None
        hashed = _of_file_3(entry.name, known)
        return record(label=label, name=entry.name, options=entry.options, data=hashed, **handled)

    def optimizer(label: str) -> str:
        entry = entries[1].get(label, Entry(label, label))
        hashed = {} if is_imported(entry.name) else _of_file_3(entry.name, code.get(label))
        return record(label=label, name=entry.name, options=entry.options, code=hashed)

    problems = {label: problem(label) for label in {one for one, _ in labels.values()}}
    optimizers = {label: optimizer(label) for label in {other for _, other in labels.values()}}
    cells = {}
    for number, (one, other) in labels.items():
        spent = study.evaluations(dimensions[one]) if study and one in dimensions and not study.imported else 0
        cells[number] = Cell(problems[one], optimizers[other], spent, study.seed if study else 0)
    selected = {number: pair for number, pair in labels.items() if pair[0] in entries[0] and pair[1] in entries[1]}
    return cells, selected, study


def _of_file_3(name: str, noted: Any) -> Any:
    """Return the hash that a record gets of the code or data of a plug-in, which was noted if it is in a file."""
    if (parts := from_file.split(name)) is None:
        return noted
    try:
        same = hashlib.sha256(parts[0].read_bytes()).hexdigest()[:16] == noted
    except OSError:
        same = True  # nobody knows
    return None if same else noted


def _noted_3(older: Older) -> tuple[list[dict[str, str]], list[dict[str, str]]]:
    """Return the hashes of data and of code that each run noted, by label, the last run first."""
    notes: tuple[list[dict[str, str]], list[dict[str, str]]] = [], []
    with suppress(sqlite3.DatabaseError):
        query = f"SELECT record FROM {older.prefix}environments ORDER BY id DESC"
        for (text,) in older.connection.execute(query).fetchall():
            with suppress(ValueError):
                noted = parse_json(text)
                for key, found in zip(("data", "code"), notes, strict=True):
                    found.append(dict(noted.get(key) or {}))
    return notes


# from layout 4, in which trials had no largest call, no failures and no log

_VALUES_4 = (
    "environment", "seed", "status", "fun", "nfev", "calls", "wall_s", "cpu_s", "objective_s", "stop", "outside_box",
    "error", "x", "metrics", "trace",
)  # fmt: skip

_SCHEMA_4 = """
CREATE TABLE committed (commits INTEGER NOT NULL, trials INTEGER NOT NULL);
CREATE TABLE environments (id INTEGER PRIMARY KEY, record TEXT NOT NULL, digest BLOB);
CREATE TABLE problems (id INTEGER PRIMARY KEY, record TEXT NOT NULL UNIQUE);
CREATE TABLE optimizers (id INTEGER PRIMARY KEY, record TEXT NOT NULL UNIQUE);
CREATE TABLE cells (
    id INTEGER PRIMARY KEY, problem INTEGER NOT NULL REFERENCES problems,
    optimizer INTEGER NOT NULL REFERENCES optimizers, evaluations INTEGER NOT NULL, seed INTEGER NOT NULL,
    UNIQUE (problem, optimizer, evaluations, seed)
);
CREATE TABLE study (identity TEXT NOT NULL, looks TEXT NOT NULL, digest BLOB NOT NULL);
CREATE TABLE selected (
    cell INTEGER PRIMARY KEY REFERENCES cells, problem TEXT NOT NULL, optimizer TEXT NOT NULL,
    UNIQUE (problem, optimizer)
);
CREATE TABLE names (
    id INTEGER PRIMARY KEY, variables TEXT NOT NULL, metric_names TEXT NOT NULL, UNIQUE (variables, metric_names)
);
CREATE TABLE results (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, digest BLOB, names INTEGER REFERENCES names,
    environment INTEGER REFERENCES environments, seed INTEGER, status TEXT NOT NULL, fun REAL, nfev INTEGER, \
calls INTEGER, wall_s REAL, cpu_s REAL, objective_s REAL, stop TEXT, outside_box INTEGER, error TEXT, x BLOB, \
metrics BLOB, trace BLOB, PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE VIEW trials AS
    SELECT problem, optimizer, trial, variables, metric_names, environment, seed, status, fun, nfev, calls, wall_s, \
cpu_s, objective_s, stop, outside_box, error, x, metrics, trace
    FROM results JOIN selected ON selected.cell = results.cell LEFT JOIN names ON names.id = results.names;
PRAGMA user_version = 4
"""


def _from_4(older: Older, put: Put) -> None:
    """Fill the tables of layout 5."""
    older.move(put, "committed", "environments", "names", "problems", "optimizers", "cells", "study", "selected")
    records = [
        {number: decoded(text) for number, (text,) in older.texts(table).items()}
        for table in ("problems", "optimizers")
    ]
    cells = {
        number: Cell(records[0][problem], records[1][optimizer], *conditions)
        for number, (problem, optimizer, *conditions) in older.texts("cells").items()
        if problem in records[0] and optimizer in records[1]
    }
    bound = {number: lambda *names, of=cell: binding_of(of, names) for number, cell in cells.items()}
    _move_results(older, put, (_VALUES_4, VALUES), bound, cells)


STEPS = {3: Step(_SCHEMA_3, _from_3), 4: Step(_SCHEMA_4, _from_4)}
"""The steps, by the layout that they read."""
