"""The tidy frame of stored trials, made column by column, as a study may have millions of trials."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.columns import FRAME, STORED, VECTORS
from bench.errors import BenchError
from bench.storage.reading import READ
from bench.storage.rows import TEXTS

COLUMNS = (*(column.name for column in FRAME), "environment")
NUMBERS = {each.name: each.kind is int for each in STORED if each.kind in (int, float) and each.name != "seed"}
"""Whether the numbers of a column are whole, unless some are missing."""

UNKNOWN = -1
"""Stands for the seed of an imported trial, as floats would lose digits of the others."""

Array = NDArray[Any]
Cell = tuple[str, str, str]
"""The names of study, problem and optimizer."""


class Tidy:
    """The columns of a tidy frame that is made of the rows of one store after another."""

    def __init__(self) -> None:
        self._numbers: dict[str, Array] = {name: np.empty(0) for name in NUMBERS}
        self._integers: dict[str, Array] = {name: np.empty(0, np.int64) for name in ("trial", "seed")}
        self._codes: dict[str, Array] = {name: np.empty(0, np.int32) for name in ("cell", *TEXTS)}
        self._known: dict[str, dict[Any, int]] = {name: {} for name in self._codes}  # number of each value
        self._vectors: dict[str, dict[str, Array]] = {column.name: {} for column in VECTORS}
        self._names: dict[str, set[tuple[str, str]]] = {}  # of variables and metrics, by problem
        self._rows = self._room = 0

    def reserve(self, rows: int) -> None:
        """Make room for further rows at once: many small arrays would leave gaps in the memory."""
        self._room += rows
        for columns in (self._numbers, self._integers, self._codes, *self._vectors.values()):
            for name, array in columns.items():
                columns[name] = np.append(array, np.full(rows, np.nan if array.dtype == float else 0, array.dtype))

    def add(
        self,
        rows: Sequence[Sequence[Any]],
        cells: Mapping[int, Cell],
        names: Mapping[int, tuple[str, str]],
        environments: Mapping[int, int],
    ) -> None:
        """Add the rows of one store, for which there must be room.

        Args:
            rows: of the columns ``READ``, texts as UTF-8.
            cells: study, problem and optimizer by the number of the cell.
            names: the names of variables and of metrics by their number, each a JSON list.
            environments: the number of an environment in the frame, by its number in the store.

        Raises:
            BenchError: where a point or the metrics of a row do not fit their names.
        """
        columns = dict(zip(READ, zip(*rows, strict=True), strict=True))
        columns["environment"] = tuple(map(environments.get, columns["environment"]))
        here = slice(self._rows, self._rows + len(rows))
        self._rows += len(rows)
        for name, array in self._numbers.items():
            array[here] = np.array(columns[name], dtype=float)
        self._integers["trial"][here] = columns["trial"]
        self._integers["seed"][here] = [UNKNOWN if seed is None else seed for seed in columns["seed"]]
        for name in self._codes:
            numbered = self._known[name]
            values = {stored: cells[stored] if name == "cell" else stored for stored in {*columns[name]}}
            numbers = {stored: numbered.setdefault(value, len(numbered)) for stored, value in values.items()}
            alike = len(numbers) == 1  # as most columns of a cell have it
            self._codes[name][here] = [*numbers.values()] if alike else [numbers[stored] for stored in columns[name]]
        for cell, number in {*zip(columns["cell"], columns["names"], strict=True)}:
            if number is not None:
                self._names.setdefault(cells[cell][1], set()).add(names[number])
        distinct = {*columns["names"]}
        for number in distinct - {None}:
            chosen = [place for place, names_number in enumerate(columns["names"]) if names_number == number]
            for name, listed in zip(self._vectors, names[number], strict=True):
                packed = columns[name] if len(distinct) == 1 else [columns[name][place] for place in chosen]
                try:
                    self._put(name, json.loads(listed), packed, here.start, chosen)
                except (TypeError, ValueError) as error:
                    _, problem, optimizer = cells[columns["cell"][chosen[0]]]
                    raise BenchError(
                        f"the store is damaged: {name!r} of a trial of {optimizer} on {problem} cannot be read; "
                        "restore it from a copy"
                    ) from error

    def _put(self, column: str, names: list[str], values: Sequence[bytes], start: int, places: list[int]) -> None:
        """Put the numbers of some rows, of which each has all of them in one text of bytes, into columns by name."""
        table = np.frombuffer(b"".join(values), "<f8").reshape(len(values), len(names))
        index = slice(start, start + len(places)) if places[-1] + 1 == len(places) else np.array(places) + start
        for name, numbers in zip(names, table.T, strict=True):
            if name not in self._vectors[column]:
                self._vectors[column][name] = np.full(self._room, np.nan)
            self._vectors[column][name][index] = numbers

    def frame(self, problems: Sequence[str], optimizers: Sequence[str]) -> pd.DataFrame:
        """Return the frame, sorted by problem, optimizer (as listed) and trial; the rows are no longer held here.

        Its columns are ``COLUMNS``, one ``x_<variable>`` for each variable of any problem, and one for each domain
        metric, whatever the order in which the rows were committed.
        """
        if not self._rows:
            return pd.DataFrame(columns=[*COLUMNS])
        order = self._order(problems, optimizers)
        series: dict[str, Any] = dict.fromkeys(COLUMNS)
        cells = self._codes.pop("cell")[order]
        for place, name in enumerate(("study", "problem", "optimizer")):
            series[name] = _taken([cell[place] for cell in self._known["cell"]], cells)
        del cells
        for name in TEXTS:
            texts = [None if text is None else text.decode() for text in self._known[name]]
            series[name] = _taken(texts, self._codes.pop(name)[order])
        for name in ("trial", "seed"):
            series[name] = self._integers.pop(name)[order]
        if (unknown := series["seed"] == UNKNOWN).any():
            series["seed"] = pd.arrays.IntegerArray(series["seed"], unknown)
        for name, whole in NUMBERS.items():
            series[name] = _numbers(self._numbers.pop(name)[order], whole=whole)
        shown = [lists for problem in problems for lists in sorted(self._names.get(problem, ()))]
        for place, column in enumerate(VECTORS):
            for name in dict.fromkeys(listed for lists in shown for listed in json.loads(lists[place])):
                series[f"{column.prefix}{name}"] = self._vectors[column.name].pop(name)[order]
        return pd.DataFrame(series, copy=False)  # a copy would gather columns of a type, and double them for a while

    def _order(self, problems: Sequence[str], optimizers: Sequence[str]) -> Array:
        """Return the places of the rows in the order of the frame."""
        cells = pd.DataFrame([*self._known["cell"]], columns=["study", "problem", "optimizer"])
        first, second = (
            pd.Index(among).get_indexer(pd.Index(cells[name]))[self._codes["cell"][: self._rows]].astype(np.int32)
            for name, among in (("problem", problems), ("optimizer", optimizers))
        )
        return np.lexsort((self._integers["trial"][: self._rows], second, first)).astype(np.int32)


def _taken(values: Sequence[str | None], places: Array) -> pd.Series:
    return pd.Series([*values]).take(places).reset_index(drop=True)


def _numbers(column: Array, *, whole: bool) -> Array:
    """Return a column of numbers; of None alone, where no trial has one."""
    present = ~np.isnan(column)
    if not present.any():
        return np.full(len(column), None, dtype=object)
    return column.astype(np.int64) if whole and present.all() else column
