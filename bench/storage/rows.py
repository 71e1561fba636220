"""A trial's row as the store keeps it, and the digest that shows whether it is still as it was written.

A digest is a hash of 8 bytes that binds all values of a row to the trial's identity and to the names of its variables
and metrics. A row whose bytes changed, that was edited by a program other than this package, or that was moved to
another trial or cell does not fit its digest. The hash has no key: code that imports this package can write digests
that fit, and only making the trial again shows such a row.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from hashlib import blake2b
from marshal import dumps
from typing import Any

from bench.trial.columns import KEY, STORED, VECTORS, Row

NAMES = tuple(column.names for column in VECTORS)
VALUES = tuple(column.name for column in STORED)
COLUMNS = (*KEY, *NAMES, *VALUES)
"""The columns of a row, as the store yields and takes it."""

TEXTS = tuple(column.name for column in STORED if column.kind is str)
FORMAT = 2  # of marshal: the last one in which equal values have equal bytes; tests hold these bytes


def decoded(stored: Any) -> str:
    """Return a text from its UTF-8, which may be damaged."""
    return stored.decode(errors="replace") if isinstance(stored, bytes) else str(stored)


def disagreement(one: Row, other: Row) -> str:
    """Return the first column that repeats and in which two rows of one trial, traces included, differ; "" for none."""
    names = (*NAMES, *(column.name for column in STORED if column.repeats))
    return next((name for name in names if one.get(name) != other.get(name)), "")


def typed(row: Row) -> list[Any]:
    """Return the ``VALUES`` of a row as SQLite will return them, where NaN is NULL.

    Raises:
        ValueError: for a column that the store does not have.
    """
    if unknown := row.keys() - {*COLUMNS}:
        raise ValueError(f"a row has no column {min(unknown)!r}")
    values = (None if row.get(column.name) is None else column.kind(row[column.name]) for column in STORED)
    # 0.0 for -0.0, whose sign SQLite does not keep.
    return [None if value != value else value + 0.0 if type(value) is float else value for value in values]


def binding(cell: Iterable[object], names: Iterable[bytes | None]) -> bytes:
    """Return the hash that begins the digests of a cell's rows whose variables and metrics have these names."""
    texts = *(str(part).encode() for part in cell), *names
    return blake2b(dumps(texts, FORMAT), digest_size=16).digest()


def digest(bound: bytes, values: Sequence[Any]) -> bytes:
    """Return the digest of a row, given as its trial's number and its ``VALUES``, texts as UTF-8."""
    return blake2b(bound + dumps(tuple(values), FORMAT), digest_size=8).digest()
