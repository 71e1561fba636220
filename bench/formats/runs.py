"""One run of another tool's results, and the checks of files that all readers of formats share."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import TypeVar

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.contract.numbers import LARGEST_BUDGET
from bench.contract.objective import Trace
from bench.contract.typing import Floats
from bench.formats.source import Source
from bench.helpers.errors import BenchError
from bench.helpers.text import is_formula, printable
from bench.study.entries import LONGEST_LABEL
from bench.trial.columns import COLUMNS, Row

LARGEST_DIMENSION = 1_000_000

Part = TypeVar("Part")
Found = TypeVar("Found")


@dataclass
class Reading:
    """The parts that the reader of a format may leave out, and its messages.

    Attributes:
        partial: whether the parts that cannot be read are left out; else the first one ends the import.
        left_out: a sentence on each part that was left out, which names its file.
        notes: further sentences for the user.
        columns: the names of columns of a table by what they are, as the user gave them.
        maximise: whether higher values of a table are better.
    """

    partial: bool = False
    left_out: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    columns: Mapping[str, str] = field(default_factory=dict)
    maximise: bool = False

    def each(self, parts: Iterable[Part], read: Callable[[Part], Iterable[Found]]) -> Iterator[Found]:
        """Yield the content of each part that can be read whole; raises BenchError unless parts may be left out."""
        for part in parts:
            try:
                contents = list(read(part))
            except BenchError as error:
                if not self.partial:
                    raise
                self.left_out.append(str(error))
            else:
                yield from contents


@dataclass(frozen=True)
class ImportedRun:
    """One run of an optimizer on a problem; what the format does not hold stays unknown.

    Attributes:
        problem: the label of the problem.
        optimizer: the label of the optimizer.
        dimension: search variables, None where the format does not say.
        nfev: evaluations made.
        trace: the best-so-far objective value over evaluations, improvements only.
        number: the number of the trial, None to number the runs of a cell in their order.
        columns: further columns of the trial's row, such as ``seed`` and ``x``.
    """

    problem: str
    optimizer: str
    dimension: int | None
    nfev: int
    trace: Trace
    number: int | None = None
    columns: Row = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise BenchError for a number that no run has, and that a store or a report could not hold."""
        what = f"a run of {self.optimizer} on {self.problem} has"
        given = {"dimension": self.dimension, **self.columns, "nfev": self.nfev, "trial": self.number}
        limits = {column.name: column.limits.most for column in COLUMNS if column.kind is int}
        for name, most in ({"dimension": LARGEST_DIMENSION} | limits).items():
            if (value := given.get(name)) is not None and not 0 <= value <= most:
                raise BenchError(f"{what} {name} {value}, which must be from 0 to {most}")
        if -np.inf in (self.fun, self.columns.get("fun")):
            raise BenchError(f"{what} the value -inf, with which no other value can be compared")

    @property
    def fun(self) -> float:
        """The best objective value, +inf where none is finite."""
        return float(self.trace.values[-1]) if len(self.trace.values) else np.inf


@dataclass(frozen=True)
class FormatReader:
    """The reader of a format.

    Attributes:
        index: the file with which reading begins, in words.
        is_index: whether a file of the source is one.
        runs: yields the runs of every such file of the source; raises BenchError for what cannot be read.
    """

    index: str
    is_index: Callable[[Source, PurePosixPath], bool]
    runs: Callable[[Source, Sequence[PurePosixPath], Reading], Iterator[ImportedRun]]


def improvements(evaluations: NDArray[np.int64], values: Floats) -> Trace:
    """Return the improvements among the values of a run, in order of evaluations; infinite values are none."""
    best = np.minimum.accumulate(values)
    new = best < np.append(np.inf, best[:-1])
    return Trace(evaluations[new], best[new])


def by_run(
    table: pd.DataFrame, keys: Sequence[str]
) -> tuple[pd.DataFrame, Iterator[tuple[tuple[str, str, int], slice]]]:
    """Return a table with the rows of each run together, and the key and the rows of each run.

    Runs stand in order of their first rows. All are brought together at once: a table may hold as many runs as rows.
    """
    runs = table.groupby([*keys], sort=False).ngroup().to_numpy()
    rows = table.iloc[np.argsort(runs, kind="stable")]
    ends = (np.flatnonzero(np.diff(np.sort(runs), append=-1)) + 1).tolist()
    starts = [0, *ends][:-1]
    heads = zip(*(rows[name].iloc[starts].tolist() for name in keys), strict=True)
    return rows, zip(heads, map(slice, starts, ends), strict=True)


def require_increasing(
    evaluations: NDArray[np.int64], lines: Iterable[int], file: str, *, repeats: bool = False
) -> None:
    """Raise BenchError where evaluation counts do not increase from at least 1.

    Args:
        evaluations: (m,) of one run.
        lines: the line of each in the file.
        file: its name.
        repeats: whether a count may occur several times in a row.
    """
    steps = np.diff(evaluations)
    wrong = np.flatnonzero(np.append(evaluations[:1] < 1, steps < 0 if repeats else steps < 1))
    if len(wrong):
        place = int(wrong[0])
        before = f"after evaluation {evaluations[place - 1]}" if place else "where a run begins"
        line = list(lines)[place]
        raise BenchError(
            f"{file}, line {line}, has evaluation {evaluations[place]} {before}; the evaluations of a run must increase"
        )


def optimizer_labels(named: Iterable[tuple[PurePosixPath, str, Hashable]]) -> dict[tuple[PurePosixPath, str], str]:
    """Return the label of each algorithm in a folder: its own name, or the folder's where runs would be mixed.

    Several folders of one algorithm are one experiment in parts where they have different names and no data set in
    common, and also where they have the same name, as in ``bbob/gwo`` and ``bbob-noisy/gwo``. Otherwise they are
    experiments that share a name.

    Args:
        named: folder, algorithm and what identifies a data set, such as its function and dimension.
    """
    held: dict[str, dict[PurePosixPath, set[Hashable]]] = {}
    for folder, name, data in named:
        held.setdefault(name, {}).setdefault(folder, set()).add(data)
    apart = {
        name
        for name, folders in held.items()
        if len({folder.name for folder in folders}) > 1
        and sum(map(len, folders.values())) > len(set().union(*folders.values()))
    }
    return {
        (folder, name): folder.name if name in apart and folder.name else name
        for name, folders in held.items()
        for folder in folders
    }


def inside(folder: PurePosixPath, name: object, where: str) -> PurePosixPath:
    """Return the path of a file that an index in ``folder`` names; raises BenchError for one outside the folder."""
    path = PurePosixPath(str(name).replace("\\", "/"))
    if path.is_absolute() or ".." in path.parts:
        raise BenchError(f"{where} names {quoted(path)}, which is outside the folder")
    return folder / path


def evaluation(text: str) -> int:
    """Return the number of an evaluation in a file; raises ValueError for a text that is none, or is too large."""
    number = int(text)
    if number > LARGEST_BUDGET:
        raise ValueError(f"{number} is too large")
    return number


def label(text: object, where: str) -> str:
    """Return the name of a problem or an optimizer as a label; raises BenchError for one that cannot be."""
    name = str(text).strip()
    if not name or not name.isprintable() or len(name) > LONGEST_LABEL or is_formula(name):
        raise BenchError(f"{where} has a name that is empty, too long, not printable or a formula: {quoted(name)}")
    return name


def quoted(text: object) -> str:
    """Return text of a file as a message quotes it: printable, and at most 60 characters."""
    return repr(printable(str(text), 60))
