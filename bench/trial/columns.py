"""The columns of a trial: their names, types, units, bounds and meanings, in one table.

From :data:`COLUMNS` follow what is checked of an answer, the tables of a store, the tidy frame, imports, exports and
the reference page. A further column is a line here; a search's, also a field of the result or of its parts.

A trial takes five forms: the result in its process, the answer (JSON) that crosses to the parent, the row that the
parent makes of it once it is checked, the row of the store, and that of the frame.
"""

import json
import struct
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

from bench.contract.numbers import LARGEST_BUDGET, LARGEST_SEED, MOST_TRIALS

Row = dict[str, Any]
"""A trial's columns by name as a store keeps them; those that are missing are unknown."""


class Limits(NamedTuple):
    """What a number may be: from ``least`` to ``most``, and at most "budget" or another column, ``within``."""

    least: float = -inf
    most: float = inf
    within: str = ""


UNLIMITED = Limits()
_UP_TO_NFEV = Limits(0, within="nfev")


@dataclass(frozen=True)
class Column:
    """A column of a trial.

    Attributes:
        name: in Python, SQL and frames.
        kind: its type, int, float, str or bytes.
        meaning: a phrase for people.
        unit: of a number, "" without one.
        limits: of a number.
        names: of bytes that hold float64 numbers, the column in which a store has their names, as a JSON list.
        prefix: before such a name in the frame.
        frame: whether the tidy frame has it.
        stored: whether a store has it; other columns are computed when a frame is read.
        repeats: whether it is the same whenever the trial is made.
    """

    name: str
    kind: type
    meaning: str
    unit: str = ""
    limits: Limits = UNLIMITED
    names: str = ""
    prefix: str = ""
    frame: bool = True
    stored: bool = True
    repeats: bool = True


MEASURED = (
    Column("fun", float, "lowest objective value found, +inf where no point counts"),
    Column("nfev", int, "evaluations made", limits=Limits(1, LARGEST_BUDGET, "budget")),
    Column("calls", int, "calls of the objective, each with a batch of points", limits=Limits(1, within="nfev")),
    Column("largest_call", int, "most points in a call of the objective", limits=Limits(1, within="nfev")),
    Column("wall_s", float, "wall time of the whole search", "s", Limits(0), repeats=False),
    Column("cpu_s", float, "processor time of the whole search", "s", Limits(0), repeats=False),
    Column("objective_s", float, "wall time inside the problem's `evaluate`", "s", Limits(0), repeats=False),
    Column(
        "memory_mb", float, "growth of the process's peak memory in the search; less where the process has made a run "
        "of the optimizer before, so that the most of several runs counts", "MB", Limits(0), repeats=False,
    ),
    Column(
        "stop", str, "`budget`; `time` or `target`, where the study's `time` or value ended it before; or the reason "
        "that the optimizer declared, or `undeclared` without one",
    ),
    Column("outside_box", int, "evaluations outside the box", limits=_UP_TO_NFEV),
    Column("failures", int, "evaluations that failed and count with the value +inf (`on_error`)", limits=_UP_TO_NFEV),
)  # fmt: skip
"""The columns that a search fills in, each a single value."""

COLUMNS = (
    Column("study", str, "name of the study", stored=False),
    Column("problem", str, "label of the problem"),
    Column("optimizer", str, "label of the optimizer"),
    Column("trial", int, "number of the trial in its cell, from 0", limits=Limits(0, MOST_TRIALS - 1)),
    Column("environment", int, "number of the record of the run that made the trial", frame=False, repeats=False),
    Column("inputs", int, "number of the record of what the trial was made from", frame=False, repeats=False),
    Column("seed", int, "seed that repeats the trial", limits=Limits(0, LARGEST_SEED)),
    Column("status", str, "`ok`, `failed` or `timeout`"),
    *MEASURED,
    Column(
        "error", str, "why the trial was lost; begins with `ProblemError: ` where the problem's own code raised"
    ),
    Column("x", bytes, "best point, by variable", names="variables", prefix="x_"),
    Column("metrics", bytes, "domain metrics of the best point, by name", names="metric_names"),
    Column("log", bytes, "what the optimizer logged, by name: pairs of evaluations and values, as JSON", frame=False),
    Column(
        "trace", bytes, "improvements: m int64 counts of evaluations, then m float64 best-so-far values", frame=False
    ),
)  # fmt: skip
"""All columns, in the order of stores and frames."""

PRECISION = Column("precision", float, "`fun` less the known optimum, after `fun`, of problems of suites", stored=False)

FEATURES = tuple(
    Column(name, kind, f"{meaning}, as far as it says so", stored=False)
    for name, kind, meaning in (
        ("suite", str, "suite of the problem"), ("function", str, "function of the problem"),
        ("dimension", int, "search variables of the problem"), ("instance", int, "instance of the problem"),
        ("group", str, "group of the problem"),
    )
)  # fmt: skip
"""The columns of a frame that say of which kind a problem is."""

KEY = ("problem", "optimizer", "trial")
STORED = tuple(column for column in COLUMNS if column.stored and column.name not in KEY)
"""The columns of a store's row beside its key."""

VECTORS = tuple(column for column in COLUMNS if column.names)
"""The columns that hold little-endian 8-byte floats by name; any number of columns of a frame."""

FRAME = tuple(column for column in COLUMNS if column.frame and not column.names)
"""The columns that every frame has."""

RESERVED = frozenset(column.name for column in (*FRAME, PRECISION))
"""What no metric may be called."""


def packed(row: Row) -> Row:
    """Return a row as a store keeps it, of one whose point and metrics are by name and whose trace is a trace.

    Raises:
        struct.error: for a value of the point or the metrics that is no number.
    """
    packed_row = dict(row)
    if any(column.name in row for column in VECTORS):
        for column in VECTORS:
            values = row.get(column.name) or {}
            packed_row[column.name] = struct.pack(f"<{len(values)}d", *values.values())
            packed_row[column.names] = json.dumps([*values])
    if row.get("trace") is not None:
        packed_row["trace"] = row["trace"].packed()
    return packed_row


def named(row: Row, name: str) -> Any:
    """Return a value of a row for people: a point and metrics by name, other values as they are."""
    names = next((column.names for column in VECTORS if column.name == name), "")
    if not names or row.get(name) is None:
        return row.get(name)
    values = struct.unpack(f"<{len(row[name]) // 8}d", row[name])
    return dict(zip(json.loads(row[names]), values, strict=True))
