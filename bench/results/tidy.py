"""The tidy frame of stored trials, made column by column, as a study may have millions of trials."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.helpers.errors import BenchError
from bench.storage.reading import READ
from bench.storage.rows import TEXTS
from bench.trial.columns import FRAME, STORED, VECTORS

COLUMNS = (*(column.name for column in FRAME), "environment")
NUMBERS = {
    each.name: each.kind is int for each in STORED if each.kind in (int, float) and each.name not in ("seed", "inputs")
}
"""Whether the numbers of a column are whole, unless some are missing."""

UNKNOWN = -1
"""Stands for the seed of an imported trial, as floats would lose digits of the others."""

Array = NDArray[Any]
Cell = tuple[str, str, str]
"""The names of study, problem and optimizer."""


class Tidy:
    """The columns of a tidy frame that is made of the rows of one store after another, some rows at a time."""

    def __init__(self) -> None:
        self._parts: dict[str, list[Array]] = {name: [] for name in (*NUMBERS, "trial", "seed", "cell", *TEXTS)}
        self._known: dict[str, dict[Any, int]] = {name: {} for name in ("cell", *TEXTS)}  # number of each value
        self._vectors: dict[str, dict[str, list[tuple[Array, Array]]]] = {column.name: {} for column in VECTORS}
        self._names: dict[str, set[tuple[bytes, ...]]] = {}  # of variables and metrics, by problem
        self._rows = 0

    def add(
        self,
        rows: Sequence[Sequence[Any]],
        cells: Mapping[int, Cell],
        names: Mapping[int, tuple[bytes, ...]],
        environments: Mapping[int, int],
    ) -> None:
        """Add the rows of one store.

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
        columns["seed"] = tuple(UNKNOWN if seed is None else seed for seed in columns["seed"])
        for name, parts in self._parts.items():
            if (numbered := self._known.get(name)) is None:
                parts.append(np.array(columns[name], dtype=float if name in NUMBERS else np.int64))
                continue
            meant = {stored: cells[stored] if name == "cell" else stored for stored in {*columns[name]}}
            numbers = {stored: numbered.setdefault(value, len(numbered)) for stored, value in meant.items()}
            parts.append(np.fromiter(map(numbers.__getitem__, columns[name]), np.int32, len(rows)))
        for cell, number in {*zip(columns["cell"], columns["names"], strict=True)}:
            if number is not None:
                self._names.setdefault(cells[cell][1], set()).add(names[number])
        for number in {*columns["names"]} - {None}:
            places = [place for place, names_number in enumerate(columns["names"]) if names_number == number]
            for name, listed in zip(self._vectors, names[number], strict=True):
                try:
                    packed = b"".join(columns[name][place] for place in places)
                    table = np.frombuffer(packed, "<f8").reshape(len(places), -1)
                    for each, values in zip(json.loads(listed), table.T, strict=True):
                        part = np.array(places, np.int32) + self._rows, values
                        self._vectors[name].setdefault(each, []).append(part)
                except (TypeError, ValueError) as error:
                    _, problem, optimizer = cells[columns["cell"][places[0]]]
                    raise BenchError(
                        f"the store is damaged: {name!r} of a trial of {optimizer} on {problem} cannot be read; "
                        "restore it from a copy"
                    ) from error
        self._rows += len(rows)

    def frame(self, problems: Mapping[str, int], optimizers: Mapping[str, int]) -> pd.DataFrame:
        """Return the frame, sorted by problem, optimizer (by these places) and trial; the rows are no longer held here.

        Its columns are ``COLUMNS``, one ``x_<variable>`` for each variable of any problem, and one for each domain
        metric, whatever the order in which the rows were committed.
        """
        if not self._rows:
            return pd.DataFrame(columns=[*COLUMNS])
        whole = {name: np.concatenate(self._parts.pop(name)) for name in ("cell", "trial")}
        ranks = np.array([problems[p] * len(optimizers) + optimizers[o] for _, p, o in self._known["cell"]])
        order = np.lexsort((whole["trial"], ranks[whole["cell"]])).astype(np.int32)
        series: dict[str, Any] = dict.fromkeys(COLUMNS)
        for place, name in enumerate(("study", "problem", "optimizer")):
            series[name] = _taken([cell[place] for cell in self._known["cell"]], whole["cell"][order])
        series["trial"] = whole["trial"][order]
        for name in [*self._parts]:
            values = np.concatenate(self._parts.pop(name))[order]
            if name in TEXTS:
                texts = [None if text is None else text.decode() for text in self._known[name]]
                series[name] = _taken(texts, values)
            elif name in NUMBERS:
                series[name] = _numbers(values, whole=NUMBERS[name])
            else:
                unknown = values == UNKNOWN
                series[name] = pd.arrays.IntegerArray(values, unknown) if unknown.any() else values
        shown = [lists for problem in problems for lists in sorted(self._names.get(problem, ()))]
        for place, column in enumerate(VECTORS):
            for name in dict.fromkeys(listed for lists in shown for listed in json.loads(lists[place])):
                values = np.full(self._rows, np.nan)
                for places, numbers in self._vectors[column.name].pop(name):
                    values[places] = numbers
                series[f"{column.prefix}{name}"] = values[order]
        return pd.DataFrame(series, copy=False)  # a copy would gather columns of a type, and double them for a while


def _taken(values: Sequence[str | None], places: Array) -> pd.Series:
    return pd.Series([*values]).take(places).reset_index(drop=True)


def _numbers(column: Array, *, whole: bool) -> Array:
    """Return a column of numbers; of None alone, where no trial has one."""
    present = ~np.isnan(column)
    if not present.any():
        return np.full(len(column), None, dtype=object)
    return column.astype(np.int64) if whole and present.all() else column
