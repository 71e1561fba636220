"""Read an index of COCO (``.info``).

It has three lines for a function and dimension: keys and values, a comment, and the logs with the runs in each,
``instance:evaluations|final``. A long list of runs may go on over several lines. The archives of 2009 write paths with
backslashes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import NamedTuple

from bench.formats.runs import inside, label, optimizer_labels, quoted
from bench.formats.source import Source
from bench.helpers.errors import BenchError

_PAIR = re.compile(r"""(\w+)\s*=\s*(?:(['"])(.*?)\2(?=\s*(?:,|$))|([^,]*))""")
_ENTRY = re.compile(r"(\d+)(?::(\d+)(?:\|(.+))?)?")
_LOG = re.compile(r".*\.[tmc]?dat")


class Logged(NamedTuple):
    """A run as the index names it; evaluations and best value are None where the run was not finished."""

    instance: int
    evaluations: int | None
    final: float | None


@dataclass
class LoggedRuns:
    """The runs of an algorithm on a function in one dimension.

    Logs end in ``.dat`` here; other endings stand for the same runs.
    """

    index: PurePosixPath
    line: int
    suite: str
    function: str
    dimension: int
    algorithm: str
    comment: str = ""
    logs: list[tuple[PurePosixPath, list[Logged]]] = field(default_factory=list)

    @property
    def where(self) -> str:
        """The place of its first line, as a message begins with it."""
        return f"{self.index}, line {self.line},"

    @property
    def runs(self) -> Iterator[tuple[PurePosixPath, Logged]]:
        """The runs, each with its log."""
        return ((log, run) for log, runs in self.logs for run in runs)


def data_sets(source: Source, file: PurePosixPath) -> Iterator[LoggedRuns]:
    """Yield the data sets of an index.

    Raises:
        BenchError: with the line that cannot be read, and for an index that is cut short.
    """
    data: LoggedRuns | None = None
    for number, line in enumerate(source.text(file).splitlines(), start=1):
        text = line.strip()
        if "funcId" in text and "=" in text.partition(",")[0]:
            if data is not None:
                yield _whole(data)
            data = _begun(text, file, number)
        elif text.startswith("%") and data is not None:
            data.comment = data.comment or text.lstrip("% ")
        elif text and not text.startswith("%"):
            if data is None:
                raise BenchError(
                    f"{file}, line {number}, is no index of COCO: it must begin with the function and dimension"
                )
            _add_runs(text, f"{file}, line {number},", data)
    if data is None:
        raise BenchError(f"{file} is empty, and no index of COCO")
    yield _whole(data)


def by_log(sets: Iterable[LoggedRuns]) -> dict[PurePosixPath, list[tuple[LoggedRuns, Logged]]]:
    """Return the runs of all data sets by log, in the order in which the indices name them."""
    runs: dict[PurePosixPath, list[tuple[LoggedRuns, Logged]]] = {}
    for data in sets:
        for log, run in data.runs:
            runs.setdefault(log, []).append((data, run))
    return runs


def algorithm_labels(sets: Iterable[LoggedRuns]) -> dict[tuple[PurePosixPath, str], str]:
    """Return the label of each algorithm by its folder and name (:func:`bench.formats.runs.optimizer_labels`)."""
    return optimizer_labels(
        (data.index.parent, data.algorithm, (data.suite, data.function, data.dimension, run.instance))
        for data in sets
        for _, run in data.runs
    )


def _begun(text: str, file: PurePosixPath, line: int) -> LoggedRuns:
    """Return the data set of a line of keys and values, without comment and logs."""
    where = f"{file}, line {line},"
    keys = {key: (quoted or plain).strip() for key, _, quoted, plain in _PAIR.findall(text)}
    try:
        dimension = int(keys["DIM"])
    except (KeyError, ValueError) as error:
        raise BenchError(f"{where} has no dimension (DIM)") from error
    algorithm = label(keys.get("algId") or file.parent.name or "unknown", where)
    return LoggedRuns(file, line, keys.get("suite", ""), label(keys["funcId"], where), dimension, algorithm)


def _add_runs(text: str, where: str, data: LoggedRuns) -> None:
    """Add the logs and runs of a line."""
    for item in filter(None, (part.strip() for part in text.split(","))):
        if match := _ENTRY.fullmatch(item):
            if not data.logs:
                raise BenchError(f"{where} names a run before its log: {quoted(item)}")
            instance, evaluations, final = match.groups()
            try:
                logged = Logged(
                    int(instance),
                    None if evaluations is None else int(evaluations),
                    None if final is None else float(final),
                )
            except ValueError as error:
                raise BenchError(f"{where} has the run {quoted(item)}, which cannot be read") from error
            data.logs[-1][1].append(logged)
        elif _LOG.fullmatch(item):
            data.logs.append((inside(data.index.parent, item, where).with_suffix(".dat"), []))
        elif "=" not in item:  # a remark
            raise BenchError(f"{where} has {quoted(item)} where a run such as '1:301|8.5e-02' is expected")


def _whole(data: LoggedRuns) -> LoggedRuns:
    if not data.logs:
        raise BenchError(f"{data.where} names no run; the index is cut short")
    return data
