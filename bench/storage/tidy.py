"""The tidy frame of stored trials, made column by column, as a study may have millions of trials."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from bench.storage.blocks import NUMBERS, UNKNOWN, Array, Block, First
from bench.storage.digests import JSON, TEXTS
from bench.storage.metrics import Found
from bench.trial import FRAME_COLUMNS

COLUMNS = (*FRAME_COLUMNS, "environment")
PREFIXES = dict(zip(JSON, ("x_", ""), strict=True))


def tidy(
    blocks: Iterable[tuple[str, Block]], trials: int, problems: Sequence[str], optimizers: Sequence[str]
) -> pd.DataFrame:
    """Return the tidy frame of stored trials, sorted by problem, optimizer (as listed) and trial.

    Its columns are ``COLUMNS``, one ``x_<variable>`` for each variable of any problem, and one for each domain metric,
    whatever the order of the blocks.

    Args:
        blocks: the trials, each block with the name of the study.
        trials: the number of all trials, as far as it is known: every column is one array from the beginning, as many
            small ones would leave gaps in the memory.
        problems: the problems' labels, in the study's order.
        optimizers: the optimizers' labels, likewise.
    """
    texts = {name: _Texts() for name in ("study", "problem", "optimizer", *TEXTS)}
    own = {name: _Numbers(trials) for name in NUMBERS}
    found = {name: _Scattered(trials) for name in JSON}
    shown: dict[str, First] = {}  # by problem
    rows = 0
    for study, block in blocks:
        count = int(block.runs[-1])
        for name, column in own.items():
            column.put(rows, block.numbers[name])
        for name in TEXTS:
            texts[name].add(*block.texts[name])
        texts["study"].repeat([study], [count])
        for name, values in zip(("problem", "optimizer"), zip(*block.cells, strict=True), strict=True):
            texts[name].repeat(values, np.diff(block.runs))
        for name, scattered in found.items():
            scattered.put(rows, count, block.found[name])
        for first in block.first:
            shown[first.problem] = min(shown.get(first.problem, first), first)
        rows += count
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
    names = {"x": [each.variables for each in known], "figures": [each.metrics for each in known]}
    for name, prefix in PREFIXES.items():
        listed = dict.fromkeys(each for some in names[name] for each in some)
        for each in dict.fromkeys([*listed, *sorted(found[name].filled)]):
            series[f"{prefix}{each}"] = found[name].column(each, rows)[order]
    return pd.DataFrame(series, copy=False)  # a copy would gather all columns of a type, and double them for a while


class _Texts:
    """A column of texts: each text once, and runs of equal ones."""

    def __init__(self) -> None:
        self._numbers: dict[str | None, int] = {}
        self._runs: list[tuple[Array, Any]] = []  # numbers of texts, and how often each is repeated

    def add(self, distinct: Sequence[str | None], places: Array) -> None:
        """Add a value for every trial, given as the place among distinct values."""
        if len(distinct) == 1:
            self.repeat(distinct, [len(places)])
        else:
            self._runs.append((self._known(distinct)[places], 1))

    def repeat(self, values: Sequence[str | None], times: Any) -> None:
        """Add each value as often as ``times`` says."""
        self._runs.append((self._known(values), times))

    def _known(self, values: Sequence[str | None]) -> Array:
        """Return the numbers of texts."""
        return np.array([self._numbers.setdefault(value, len(self._numbers)) for value in values], dtype=np.int32)

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
        """Put the values of a block behind those of other blocks."""
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
        """Put the columns of a block of ``count`` trials behind ``before`` others."""
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
