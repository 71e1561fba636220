"""The tidy frame of stored trials, made column by column, as a study may have millions of trials."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.errors import BenchError
from bench.storage.metrics import Damaged, Found, parsed
from bench.trial import FRAME_COLUMNS

COLUMNS = (*FRAME_COLUMNS, "environment")

UNKNOWN = -1
"""Stands for the seed of an imported trial, as floats would lose digits of the others; the frame has <NA>."""

_TEXTS = ("study", "problem", "optimizer", "status", "stop", "error")

Array = NDArray[Any]


@dataclass(frozen=True)
class Slice:
    """Some stored trials of one folder, cell by cell.

    Attributes:
        study: the name of their study.
        labels: problem and optimizer, as shown, by the number of the cell.
        columns: ``cell`` and the stored columns by name, each a sequence with a value for every trial; ``x`` and
            ``figures`` are JSON texts in UTF-8, or None.
    """

    study: str
    labels: Mapping[Any, tuple[str, str]]
    columns: Mapping[str, Sequence[Any]]


def tidy(slices: Iterable[Slice], trials: int, problems: Sequence[str], optimizers: Sequence[str]) -> pd.DataFrame:
    """Return the tidy frame of stored trials, sorted by problem, optimizer (as listed) and trial.

    Its columns are ``COLUMNS``, one ``x_<variable>`` for each variable of any problem, and one for each domain metric.

    Args:
        slices: the trials.
        trials: the number of all trials, as far as it is known: every column is one array from the beginning, as many
            small ones would leave gaps in the memory.
        problems: the problems' labels, in the study's order.
        optimizers: the optimizers' labels, likewise.

    Raises:
        BenchError: where a JSON text is damaged.
    """
    texts = {name: _Texts() for name in _TEXTS}
    own = {name: _Numbers(trials) for name in COLUMNS if name not in _TEXTS}
    found = {"x_": _Scattered(trials), "": _Scattered(trials)}
    shown: dict[str, tuple[list[str], list[str]]] = {}  # names of the variables and metrics, by problem
    rows = 0
    for each in slices:
        columns, runs = each.columns, _runs(each.columns["cell"])
        for name, column in own.items():
            column.put(rows, _seeds(columns[name]) if name == "seed" else _numbers(columns[name]))
        for name in ("status", "stop", "error"):
            texts[name].add(columns[name])
        texts["study"].repeat([each.study], runs[-1:])
        labels = [each.labels[columns["cell"][start]] for start in runs[:-1]]
        for name, values in zip(("problem", "optimizer"), zip(*labels, strict=True), strict=True):
            texts[name].repeat(values, np.diff(runs))
        for prefix, name in (("x_", "x"), ("", "figures")):
            try:
                found[prefix].put(rows, runs[-1], parsed(columns[name], runs))
            except Damaged as error:
                raise _refusal(each, name, error.place) from error
        _note_names(each, runs, labels, shown)
        rows += runs[-1]
    if not rows:
        return pd.DataFrame(columns=[*COLUMNS])
    cells = texts["optimizer"].places(optimizers), texts["problem"].places(problems)
    order = np.lexsort((own["trial"].column(rows), *cells)).astype(np.int32)
    del cells
    series: dict[str, Any] = {}
    for name in COLUMNS:
        series[name] = texts.pop(name).series(order) if name in texts else own.pop(name).column(rows)[order]
    if (unknown := series["seed"] == UNKNOWN).any():
        series["seed"] = pd.arrays.IntegerArray(series["seed"], unknown)
    # Problems may have different variables and metrics, whose columns must not be in the order of the commits.
    known = [shown[problem] for problem in problems if problem in shown]
    for place, prefix in enumerate(("x_", "")):
        names = dict.fromkeys(name for each in known for name in each[place])
        for name in dict.fromkeys([*names, *found[prefix].filled]):
            series[f"{prefix}{name}"] = found[prefix].column(name, rows)[order]
    return pd.DataFrame(series, copy=False)  # a copy would gather all columns of a type, and double them for a while


class _Texts:
    """A column of texts: each text once, and runs of equal ones."""

    def __init__(self) -> None:
        self._numbers: dict[str | None, int] = {}
        self._runs: list[tuple[Array, Any]] = []  # numbers of texts, and how often each is repeated

    def add(self, values: Sequence[str | None]) -> None:
        """Add a value for every trial."""
        if len(distinct := dict.fromkeys(values)) == 1:
            self.repeat([*distinct], np.array([len(values)]))
        else:
            self.repeat(values, 1)

    def repeat(self, values: Sequence[str | None], times: Any) -> None:
        """Add each value as often as ``times`` says: one number, or one for each value."""
        for value in dict.fromkeys(values):
            self._numbers.setdefault(value, len(self._numbers))
        self._runs.append((np.fromiter(map(self._numbers.__getitem__, values), np.int32, len(values)), times))

    def _codes(self) -> Array:
        return np.concatenate([np.repeat(numbers, times) for numbers, times in self._runs])

    def places(self, among: Sequence[str]) -> Array:
        """Return the place of every trial's value in a list."""
        places: Array = pd.Index(among).get_indexer(pd.Index([*self._numbers])).astype(np.int32)
        return places[self._codes()]

    def series(self, order: Array) -> pd.Series:
        """Return the column in that order."""
        return pd.Series([*self._numbers]).take(self._codes()[order]).reset_index(drop=True)


class _Numbers:
    """A column of numbers, of which some may be missing."""

    def __init__(self, trials: int) -> None:
        self._trials = trials
        self._array: Array | None = None
        self._some = False  # whether any is there

    def put(self, before: int, values: Array) -> None:
        """Put the values of a slice behind those of other slices."""
        if self._array is None:
            self._array = np.empty(self._trials, dtype=values.dtype)
        elif (kind := np.result_type(self._array, values)) != self._array.dtype:
            self._array = self._array.astype(kind)
        self._array = _long_enough(self._array, before + len(values))
        self._array[before : before + len(values)] = values
        self._some = self._some or values.dtype != float or not np.isnan(values).all()

    def column(self, rows: int) -> Array:
        """Return the column; of None alone, where no trial has a value."""
        if self._array is None or not self._some:
            return np.full(rows, None, dtype=object)
        return self._array[:rows]


class _Scattered:
    """Columns of values that only some trials have.

    Attributes:
        filled: by name, the number of trials that have a value.
    """

    def __init__(self, trials: int) -> None:
        self.filled: dict[str, int] = {}
        self._trials = trials
        self._floats: dict[str, Array] = {}
        self._others: dict[str, list[tuple[Any, Array]]] = {}  # as a problem's own metrics may be anything

    def put(self, before: int, count: int, found: Found) -> None:
        """Put the columns of a slice of ``count`` trials behind ``before`` others."""
        self._trials = max(self._trials, before + count)
        for name, (index, values) in found.items():
            place = slice(before, before + count) if index is None else index + before
            if values.dtype != float:
                self._others.setdefault(name, []).append((place, values))
            else:
                if name not in self._floats:
                    self._floats[name] = np.full(self._trials, np.nan)
                self._floats[name] = _long_enough(self._floats[name], before + count)
                self._floats[name][place] = values
            self.filled[name] = self.filled.get(name, 0) + len(values)

    def column(self, name: str, rows: int) -> Array:
        """Return one column and forget it; NaN stands where a trial has no value."""
        floats, others = self._floats.pop(name, None), self._others.pop(name, [])
        if floats is not None and not others:
            return _long_enough(floats, rows)[:rows]
        kinds = {values.dtype for _, values in others}
        if self.filled[name] < rows or floats is not None:
            kinds.add(np.dtype(float))
        mixed = len(kinds) > 1 and any(kind.kind not in "if" for kind in kinds)
        column = np.empty(rows, dtype=object if mixed else np.result_type(*kinds))
        if self.filled[name] < rows:
            column[:] = np.nan
        if floats is not None:
            column[:] = _long_enough(floats, rows)[:rows]
        for place, values in others:
            column[place] = values
        return column


def _long_enough(array: Array, count: int) -> Array:
    """Return an array of at least ``count`` values: a run may have added trials since they were counted."""
    if count <= len(array):
        return array
    more: Array = np.empty(count + count // 8 - len(array), dtype=array.dtype)
    more[:] = np.nan if array.dtype == float else 0
    return np.concatenate([array, more])


def _runs(cells: Sequence[Any]) -> Array:
    """Return where the runs of equal cells begin, and the number of all trials."""
    numbers = np.asarray(cells)
    return np.concatenate([[0], np.flatnonzero(numbers[1:] != numbers[:-1]) + 1, [len(numbers)]])


def _numbers(values: Sequence[Any]) -> Array:
    """Return a column as an array; missing values become NaN."""
    array = np.asarray(values)
    if array.dtype == object and all(value is None or isinstance(value, int | float) for value in values):
        return array.astype(float)
    return array


def _seeds(values: Sequence[Any]) -> Array:
    """Return seeds as whole numbers, UNKNOWN where there is none."""
    return np.array([UNKNOWN if value is None else value for value in values] if None in values else values)


def _note_names(
    each: Slice, runs: Array, labels: Sequence[tuple[str, str]], shown: dict[str, tuple[list[str], list[str]]]
) -> None:
    """Note the names of each problem's variables and metrics, in the order of its first trial that has a point."""
    points, figures = each.columns["x"], each.columns["figures"]
    for (start, end), (problem, _) in zip(pairwise(runs), labels, strict=True):
        if problem not in shown:
            first = next((row for row in range(start, end) if points[row] not in (None, b"{}")), None)
            if first is not None:
                shown[problem] = [*json.loads(points[first])], [*json.loads(figures[first] or b"{}")]


def _refusal(each: Slice, name: str, row: int) -> BenchError:
    problem, optimizer = each.labels[each.columns["cell"][row]]
    return BenchError(
        f"the store is damaged: {name!r} of trial {each.columns['trial'][row]} of {optimizer} on {problem} (study "
        f"{each.study}) cannot be read; restore it from a copy"
    )
