"""A trial's row as the store keeps it, and the digest that shows whether it is still as it was written.

A digest is a hash of 8 bytes that binds all values of a row to the trial's identity and to the names of its variables
and metrics. A row whose bytes changed, that was edited by a program other than this package, or that was moved to
another trial or cell does not fit its digest. The hash has no key: code that imports this package can write digests
that fit, and only making the trial again shows such a row.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from hashlib import blake2b
from marshal import dumps
from typing import Any

from bench.storage.traces import pack
from bench.trial import Trial

KEY = ("problem", "optimizer", "trial")
KINDS: dict[str, type] = {
    "environment": int, "seed": int, "status": str, "fun": float, "nfev": int, "wall_s": float, "cpu_s": float,
    "objective_s": float, "stop": str, "outside_box": int, "error": str, "x": bytes, "metrics": bytes, "trace": bytes,
}  # fmt: skip
"""The types of a trial's columns beside its key and its names; each may be None."""

MEASURED = tuple(KINDS)
TEXTS = tuple(name for name, kind in KINDS.items() if kind is str)
VECTORS = {"x": "variables", "metrics": "metric_names"}
"""The columns that hold little-endian 8-byte floats, and where the names of their values stand, a JSON list."""

COLUMNS = (*KEY, *VECTORS.values(), *MEASURED)
"""The columns of a row, as the store yields and takes it."""

REPEATABLE = tuple(name for name in COLUMNS[3:] if name != "environment" and not name.endswith("_s"))
"""The columns that must be identical when a trial is made twice."""

FORMAT = 2  # of marshal: the last one in which equal values have equal bytes; tests hold these bytes


def stored(trial: Trial, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a trial's row as the store yields it, from the columns of :func:`bench.trial.as_row`."""
    return packed(row) | dict(zip(KEY, trial.key, strict=True)) | {"seed": trial.seed}


def packed(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row whose point, metrics and trace are packed as bytes."""
    packed_row = dict(row)
    if not row.keys().isdisjoint(VECTORS):
        for column, names in VECTORS.items():
            values = row.get(column) or {}
            packed_row[column] = struct.pack(f"<{len(values)}d", *values.values())
            packed_row[names] = json.dumps([*values])
    if row.get("trace") is not None:
        packed_row["trace"] = pack(row["trace"])
    return packed_row


def named(row: Mapping[str, Any], column: str) -> Any:
    """Return a value of a row for people: a point and metrics by name, other values as they are."""
    if column not in VECTORS or row.get(column) is None:
        return row.get(column)
    values = struct.unpack(f"<{len(row[column]) // 8}d", row[column])
    return dict(zip(json.loads(row[VECTORS[column]]), values, strict=True))


def disagreement(one: Mapping[str, Any], other: Mapping[str, Any]) -> str:
    """Return the first of ``REPEATABLE`` in which two rows of one trial, traces included, differ; "" for none."""
    return next((name for name in REPEATABLE if one.get(name) != other.get(name)), "")


def typed(row: Mapping[str, Any]) -> list[Any]:
    """Return the ``MEASURED`` columns of a row as SQLite will return them, where NaN is NULL.

    Raises:
        ValueError: for a column that the store does not have.
    """
    if unknown := row.keys() - {*COLUMNS}:
        raise ValueError(f"a row has no column {min(unknown)!r}")
    values = (None if row.get(name) is None else kind(row[name]) for name, kind in KINDS.items())
    # 0.0 for -0.0, whose sign SQLite does not keep.
    return [None if value != value else value + 0.0 if type(value) is float else value for value in values]


def binding(*texts: bytes | None) -> bytes:
    """Return a hash of labels and names, with which the hashed bytes of a cell's rows begin."""
    return blake2b(dumps(texts, FORMAT), digest_size=16).digest()


def digest(bound: bytes, values: Sequence[Any]) -> bytes:
    """Return the digest of a row, given as its trial's number and the ``MEASURED`` columns, texts as UTF-8."""
    return blake2b(bound + dumps(tuple(values), FORMAT), digest_size=8).digest()
