"""Parse the JSON texts of many trials, of their points or of their metrics, into arrays.

The trials of a problem have texts that differ in their numbers alone. Such a run of texts is parsed in one call of
pandas' reader of numbers, without an object for each of them; any other run is parsed by Python's own parser.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.numbers import exact_csv

Array = NDArray[Any]
Found = dict[str, tuple[Array | None, Array]]
"""By name: the rows that have a value, None for all of them, and their values."""

FEW = 8  # texts in a run, on average, below which single runs gain nothing
_NUMBER = b"0123456789.-+e "  # what numbers and the gaps around them consist of


class Damaged(Exception):  # noqa: N818 - no failure of its own
    """A text is no JSON object; ``place`` is its row."""

    def __init__(self, place: int) -> None:
        super().__init__(place)
        self.place = place


def parsed(texts: Sequence[bytes | None], runs: Array) -> Found:
    """Parse the texts of a slice.

    Args:
        texts: a JSON object for every row, None or ``{}`` where it has no values.
        runs: where runs of trials of one cell begin, and the number of rows.

    Raises:
        Damaged: where a text is no JSON object.
    """
    several = len(runs) > 2 and len(texts) >= FEW * (len(runs) - 1)
    parts = []
    if (whole := _alike(texts)) is not None:
        return {name: (None, values) for name, values in whole.items()}
    for start, end in pairwise(runs) if several else [(0, len(texts))]:
        rows = np.array([row for row in range(start, end) if texts[row] not in (None, b"{}")], dtype=np.int64)
        some = [texts[row] or b"" for row in rows]
        if some:
            values = _alike(some)
            parts.append((rows, _by_python(some, rows) if values is None else values))
    names = dict.fromkeys(name for _, values in parts for name in values)
    found: Found = {}
    for name in names:
        having = [(rows, values[name]) for rows, values in parts if name in values]
        found[name] = np.concatenate([rows for rows, _ in having]), np.concatenate([values for _, values in having])
    return found


def _alike(texts: Sequence[bytes | None]) -> Mapping[str, Array] | None:
    """Parse texts that differ in their floating-point numbers alone; None where they differ otherwise."""
    try:
        first = json.loads(texts[0] or b"")
        if not first or {type(value) for value in first.values()} != {float}:
            return None
        joined = bytearray(b",".join(texts))  # type: ignore[arg-type]  # None raises
    except (AttributeError, TypeError, ValueError):
        return None
    names = [json.dumps(name).encode() for name in first]
    content = np.frombuffer(joined, dtype=np.uint8)
    quotes = np.flatnonzero(content == ord(b'"'))
    if len(quotes) != 2 * len(names) * len(texts):
        return None
    for name, begins in zip(names, quotes.reshape(len(texts), -1)[:, ::2].T, strict=True):
        if int(begins[-1]) + len(name) > len(content):
            return None
        for place, character in enumerate(name):  # blank each name out, where it is the one that belongs there
            places = begins + place
            if (content[places] != character).any():
                return None
            content[places] = ord(b":")
    del content  # a bytearray in use cannot be translated in some versions
    skeleton = b"{" + b",".join(b":" * (len(name) + 1) for name in names) + b"}"
    if joined.translate(None, _NUMBER) != b",".join([skeleton] * len(texts)):
        return None
    numbers = _numbers(bytes(joined.translate(None, b"{}:")), len(names) * len(texts))
    if numbers is None:
        return None
    return dict(zip(first, np.ascontiguousarray(numbers.reshape(-1, len(names)).T), strict=True))


def _numbers(text: bytes, count: int) -> Array | None:
    """Return so many floating-point numbers between commas, correctly rounded; None where the text has others."""
    try:
        column = pd.read_csv(
            io.BytesIO(text), header=None, lineterminator=",", dtype=float, low_memory=False, **exact_csv()
        )
    except ValueError:
        return None
    numbers = column.to_numpy()
    return None if numbers.shape != (count, 1) or np.isnan(numbers).any() else numbers[:, 0]


def _by_python(texts: Sequence[bytes], rows: Array) -> Mapping[str, Array]:
    """Parse any texts, all in one call unless one of them is damaged."""
    try:
        objects = json.loads(b"[" + b",".join(texts) + b"]")
    except ValueError:
        objects = []
    if len(objects) != len(texts) or not all(isinstance(each, dict) for each in objects):
        raise Damaged(
            next((int(row) for row, text in zip(rows, texts, strict=True) if not _is_sound(text)), int(rows[0]))
        )
    return {str(name): column.to_numpy() for name, column in pd.DataFrame(objects).items()}


def _is_sound(text: bytes) -> bool:
    try:
        return isinstance(json.loads(text), dict)
    except ValueError:
        return False
