"""Stored trials as arrays, block by block, which one process can hand to another."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.errors import BenchError
from bench.storage.digests import JSON, MEASURED, TEXTS
from bench.storage.metrics import Damaged, Found, parsed

UNKNOWN = -1
"""Stands for the seed of an imported trial, as floats would lose digits of the others."""

NUMBERS = ("trial", *(name for name in MEASURED if name not in (*TEXTS, *JSON)))

Array = NDArray[Any]


class First(NamedTuple):
    """The first trial of a problem that has a point, and the names of its variables and of its metrics."""

    cell: int
    trial: int
    problem: str
    variables: list[str]
    metrics: list[str]


class Block(NamedTuple):
    """Some trials of one store, cell by cell.

    Attributes:
        cells: problem and optimizer of each run of trials of one cell.
        runs: where runs begin, and the number of all trials.
        numbers: by column, a value for each trial: NaN where it is missing, ``UNKNOWN`` where a seed is.
        texts: by column, the distinct texts, and the place among them for each trial.
        found: by JSON column, what its texts hold.
        first: for each problem of which some trial has a point, the first one.
    """

    cells: list[tuple[str, str]]
    runs: Array
    numbers: dict[str, Array]
    texts: dict[str, tuple[list[str | None], Array]]
    found: dict[str, Found]
    first: list[First]


def pack(columns: Mapping[str, Sequence[Any]], labels: Mapping[Any, tuple[str, str]]) -> Block:
    """Return stored trials, cell by cell, as a block.

    Args:
        columns: ``cell`` and the stored columns by name; texts are UTF-8, or None; ``x`` and ``figures`` hold JSON.
        labels: problem and optimizer by the number of the cell.

    Raises:
        BenchError: where a text is no JSON object.
    """
    cells, numbers = columns["cell"], np.asarray(columns["cell"])
    runs = np.concatenate([[0], np.flatnonzero(numbers[1:] != numbers[:-1]) + 1, [len(numbers)]])
    found = {}
    for name in JSON:
        try:
            found[name] = parsed(columns[name], runs)
        except Damaged as error:
            problem, optimizer = labels[cells[error.place]]
            raise BenchError(
                f"the store is damaged: {name!r} of trial {columns['trial'][error.place]} of {optimizer} on {problem} "
                "cannot be read; restore it from a copy"
            ) from error
    return Block(
        [labels[cells[start]] for start in runs[:-1]],
        runs,
        {name: _seeds(columns[name]) if name == "seed" else _numbers(columns[name]) for name in NUMBERS},
        {name: _texts(columns[name]) for name in TEXTS},
        found,
        _first(columns, runs, labels),
    )


def _numbers(values: Sequence[Any]) -> Array:
    """Return a column as an array; missing values become NaN."""
    array = np.asarray(values)
    if array.dtype == object and all(value is None or isinstance(value, int | float) for value in values):
        return array.astype(float)
    return array


def _seeds(values: Sequence[Any]) -> Array:
    """Return seeds as whole numbers, UNKNOWN where there is none."""
    return np.array([UNKNOWN if value is None else value for value in values] if None in values else values)


def _texts(values: Sequence[bytes | None]) -> tuple[list[str | None], Array]:
    places = {value: place for place, value in enumerate(dict.fromkeys(values))}
    texts = [None if value is None else value.decode() for value in places]
    if len(texts) == 1:
        return texts, np.zeros(len(values), dtype=np.int32)
    return texts, np.fromiter(map(places.__getitem__, values), np.int32, len(values))


def _first(columns: Mapping[str, Sequence[Any]], runs: Array, labels: Mapping[Any, tuple[str, str]]) -> list[First]:
    found: dict[str, First] = {}
    points, metrics = columns["x"], columns["figures"]
    for start, end in pairwise(runs):
        cell = columns["cell"][start]
        problem, _ = labels[cell]
        if problem not in found:  # cells are in the order of their numbers
            row = next((row for row in range(start, end) if points[row] not in (None, b"{}")), None)
            if row is not None:
                names = [*json.loads(points[row])], [*json.loads(metrics[row] or b"{}")]
                found[problem] = First(cell, columns["trial"][row], problem, *names)
    return [*found.values()]
