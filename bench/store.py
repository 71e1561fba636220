"""The store of a study's folder: one committed SQLite row a trial, written by one process, read by any."""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import BenchError
from bench.objective import Trace
from bench.study import Trial

FILE = "trials.sqlite"
COLUMNS = (
    "problem", "optimizer", "trial", "seed", "status", "fun", "nfev", "wall_s", "cpu_s", "objective_s",
    "stop", "outside_box", "error", "x", "figures", "trace",
)  # fmt: skip
SCHEMA = """
CREATE TABLE IF NOT EXISTS trials (
    problem TEXT NOT NULL, optimizer TEXT NOT NULL, trial INTEGER NOT NULL, seed INTEGER NOT NULL,
    status TEXT NOT NULL, fun REAL, nfev INTEGER, wall_s REAL, cpu_s REAL, objective_s REAL,
    stop TEXT, outside_box INTEGER, error TEXT, x TEXT, figures TEXT, trace BLOB,
    PRIMARY KEY (problem, optimizer, trial)
) WITHOUT ROWID
"""


class Store:
    """The trials of one study, in ``trials.sqlite`` of its folder.

    Values are stored as SQLite's 8-byte floats or as JSON with all digits, traces as raw little-endian arrays:
    nothing is rounded and nothing is ever unpickled.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        # SQLite writes beside a store even to read it, unless it is told that nothing there can change
        frozen = self.path.exists() and not os.access(self.path.parent, os.W_OK)
        place = f"{self.path.resolve().as_uri()}?immutable=1" if frozen else str(self.path)
        try:
            connection = sqlite3.connect(place, timeout=30, uri=frozen)
        except sqlite3.Error as error:
            raise BenchError(f"the store {self.path} cannot be opened: {error}") from error
        try:
            yield connection
        except sqlite3.DatabaseError as error:
            raise BenchError(f"the store {self.path} cannot be used: {error}") from error
        finally:
            connection.close()

    @contextmanager
    def writer(self) -> Iterator[Writer]:
        """Open the store for writing, made where it is missing; every row is committed as it is added."""
        with self._open() as connection:
            connection.execute("PRAGMA journal_mode=WAL")
            connection.execute("PRAGMA synchronous=NORMAL")  # safe against a killed process; a power cut may cost rows
            connection.execute(SCHEMA)
            connection.commit()
            yield Writer(connection)

    def keys(self, *, finished_only: bool = False) -> set[tuple[str, str, int]]:
        """Return the (problem, optimizer, trial) of every stored row, or of those that did not fail."""
        if not self.path.exists():
            return set()
        query = "SELECT problem, optimizer, trial FROM trials" + (" WHERE status = 'ok'" if finished_only else "")
        return set(self._select(query))

    def rows(self) -> list[dict[str, Any]]:
        """Return every row but its trace."""
        if not self.path.exists():
            raise BenchError(f"there is no {FILE} in {self.path.parent}; give the folder that 'bench run' wrote")
        names = [name for name in COLUMNS if name != "trace"]
        rows = [dict(zip(names, row, strict=True)) for row in self._select(f"SELECT {', '.join(names)} FROM trials")]
        for row in rows:
            for name in ("x", "figures"):
                row[name] = self._parse(row[name], row) if row[name] else {}
        return rows

    def traces(self) -> dict[tuple[str, str, int], Trace]:
        """Return the anytime traces by (problem, optimizer, trial); failed trials have none."""
        query = "SELECT problem, optimizer, trial, trace FROM trials WHERE trace IS NOT NULL"
        return {(problem, optimizer, trial): _unpack(blob) for problem, optimizer, trial, blob in self._select(query)}

    def _select(self, query: str) -> list[tuple[Any, ...]]:
        """Return a query's rows; a store whose run was killed before it made the table has none."""
        with self._open() as connection:
            if not connection.execute("SELECT count(*) FROM sqlite_master WHERE name = 'trials'").fetchone()[0]:
                return []
            return connection.execute(query).fetchall()

    def _parse(self, text: str, row: dict[str, Any]) -> dict[str, float]:
        try:
            return dict(json.loads(text))
        except ValueError as error:
            raise BenchError(
                f"the store {self.path} is damaged: trial {row['trial']} of {row['optimizer']} on {row['problem']} "
                "cannot be read; restore it from a copy"
            ) from error


class Writer:
    """The one open hand that adds rows."""

    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection

    def add(self, trial: Trial, row: dict[str, Any]) -> None:
        """Commit one trial's row; a failed row of the same trial is replaced, a finished one never is."""
        values = {
            "problem": trial.problem, "optimizer": trial.optimizer, "trial": trial.number, "seed": trial.seed,
            **row,
            "x": json.dumps(row["x"]) if "x" in row else None,
            "figures": json.dumps(row["figures"]) if "figures" in row else None,
            "trace": _pack(row["trace"]) if "trace" in row else None,
        }  # fmt: skip
        with self._connection:
            self._connection.execute(
                "DELETE FROM trials WHERE problem = ? AND optimizer = ? AND trial = ? AND status != 'ok'",
                (trial.problem, trial.optimizer, trial.number),
            )
            self._connection.execute(
                f"INSERT INTO trials ({', '.join(COLUMNS)}) VALUES ({', '.join('?' * len(COLUMNS))})",
                [values.get(name) for name in COLUMNS],
            )


def _pack(trace: Trace) -> bytes:
    return trace.evaluations.astype("<i8").tobytes() + trace.values.astype("<f8").tobytes()


def _unpack(blob: bytes) -> Trace:
    half = len(blob) // 2
    return Trace(np.frombuffer(blob[:half], dtype="<i8"), np.frombuffer(blob[half:], dtype="<f8"))
