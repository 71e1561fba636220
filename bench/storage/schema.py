"""The SQLite schema of a store, and the conversion of a trial's row and trace to it and back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from bench.objective import Trace
from bench.trial import Trial

FILE = "trials.sqlite"
VERSION = 1
MEASURED = (
    "environment", "seed", "status", "fun", "nfev", "wall_s", "cpu_s", "objective_s", "stop", "outside_box", "error",
    "x", "figures",
)  # fmt: skip
"""The columns of a trial beside its key and its trace."""

KEY = ("problem", "optimizer", "trial")
REPEATABLE = tuple(name for name in (*MEASURED, "trace") if name != "environment" and not name.endswith("_s"))
"""The columns that must be identical when a trial is made twice."""

# Traces have a table of their own: they take ten times the space of the rest, and most readers need none.
SCHEMA = f"""
BEGIN;
CREATE TABLE environments (id INTEGER PRIMARY KEY, record TEXT NOT NULL);
CREATE TABLE cells (
    id INTEGER PRIMARY KEY, problem TEXT NOT NULL, optimizer TEXT NOT NULL, UNIQUE (problem, optimizer)
);
CREATE TABLE results (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, environment INTEGER REFERENCES environments,
    seed INTEGER NOT NULL, status TEXT NOT NULL, fun REAL, nfev INTEGER, wall_s REAL, cpu_s REAL, objective_s REAL,
    stop TEXT, outside_box INTEGER, error TEXT, x TEXT, figures TEXT,
    PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE TABLE traces (
    cell INTEGER NOT NULL REFERENCES cells, trial INTEGER NOT NULL, trace BLOB, PRIMARY KEY (cell, trial)
) WITHOUT ROWID;
CREATE VIEW trials AS
    SELECT problem, optimizer, trial, {", ".join(MEASURED)}, trace
    FROM results JOIN cells ON cells.id = results.cell LEFT JOIN traces USING (cell, trial);
PRAGMA user_version = {VERSION};
COMMIT;
"""


def stored(trial: Trial, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a trial's row as :meth:`Store.rows` yields it, from the columns of :func:`bench.trial.as_row`."""
    return {
        **row,
        "problem": trial.problem, "optimizer": trial.optimizer, "trial": trial.number, "seed": trial.seed,
        **{name: json.dumps(row[name]) for name in ("x", "figures") if name in row},
        **({"trace": pack(row["trace"])} if "trace" in row else {}),
    }  # fmt: skip


def disagreement(one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Return the first of ``REPEATABLE`` in which two rows of one trial, traces included, differ; "" for none."""
    return next((name for name in REPEATABLE if one.get(name) != other.get(name)), "")


def pack(trace: Trace) -> bytes:
    """Return a trace as bytes for the store."""
    return trace.evaluations.astype("<i8").tobytes() + trace.values.astype("<f8").tobytes()


def unpack(blob: bytes) -> Trace:
    """Return the trace that :func:`pack` packed."""
    half = len(blob) // 2
    return Trace(np.frombuffer(blob[:half], dtype="<i8"), np.frombuffer(blob[half:], dtype="<f8"))
