"""Read the format that IOHprofiler wrote before its JSON files: an index (``IOHprofiler_*.info``) and logs.

The index has three lines for a function and dimension, like COCO's: keys and values, a comment, and the log with the
runs in it, ``instance:evaluations|final``, where attributes of the run may follow after semicolons. A line of quoted
columns begins each run of a log. The column ``best-so-far f(x)`` is the value before the instance shifts and scales it;
in the suite BBOB it is the value less f_opt. Where only evaluations with another trigger were logged, the log is
``.cdat`` or ``.tdat``. An old index counts the evaluations of a run, a newer one those until its best value; the
logs end at the last evaluation.

Source: IOHanalyzer's description of its formats, https://iohprofiler.github.io/IOHanalyzer/data (C. Doerr, H. Wang,
F. Ye, S. van Rijn, T. Bäck, "IOHprofiler: A Benchmarking and Profiling Tool for Iterative Optimization Heuristics",
arXiv:1810.05281), and the logs of IOHexperimenter 0.3.2.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import PurePosixPath
from typing import NamedTuple

import numpy as np

from bench.errors import BenchError
from bench.importing.ioh import GUESSED, Block, is_guessed, logged, problem_of
from bench.importing.runs import Reading, Run, improvements, label, optimizer_labels, shown
from bench.importing.source import Source

VALUE = "best-so-far f(x)"
SHIFTED = "best af(x)+b"
FIRST = "function evaluation"
SUFFIXES = (".dat", ".cdat", ".tdat")

_PAIR = re.compile(r"(\w+)\s*=\s*(?:'([^']*)'|\"([^\"]*)\"|([^,]*))")
_ENTRY = re.compile(r"(\d+):(\d+)\|([^;]+)(?:;.*)?")


class Logged(NamedTuple):
    """A run as the index names it; ``final`` is its best value, before or after the instance's shift."""

    instance: int
    evaluations: int
    final: float


@dataclass
class _Data:
    """The three lines of an index."""

    index: PurePosixPath
    line: int
    suite: str
    function: str
    name: str
    dimension: int
    algorithm: str
    log: PurePosixPath = field(default_factory=PurePosixPath)  # without a name until its line is read
    entries: list[Logged] = field(default_factory=list)


def is_index(file: PurePosixPath) -> bool:
    """Return whether a file is an index of this format, by its name."""
    return file.suffix == ".info" and file.name.startswith("IOHprofiler")


def recognised(source: Source) -> bool:
    """Return whether the source holds an index of this format."""
    return any(map(is_index, source.files))


def runs(source: Source, reading: Reading) -> Iterator[Run]:
    """Yield the runs of every index, log by log.

    Raises:
        BenchError: for an index or a log that is none or is cut short, and for results of maximisation.
    """
    sets = list(reading.each(filter(is_index, source.files), partial(_index, source)))
    if any(data.function.isdigit() and is_guessed(data.suite, int(data.function), data.name) for data in sets):
        reading.notes.append(GUESSED.format("bbob"))
    names = optimizer_labels(
        (data.index.parent, data.algorithm, (data.function, data.dimension, entry.instance))
        for data in sets
        for entry in data.entries
    )
    by_log: dict[PurePosixPath, list[tuple[_Data, Logged]]] = {}
    for data in sets:
        for entry in data.entries:
            by_log.setdefault(_log_of(source, data), []).append((data, entry))

    def runs_of(log: PurePosixPath) -> Iterator[Run]:
        named = by_log[log]
        blocks = logged(source, log, FIRST, VALUE)
        if len(blocks) != len(named):
            raise BenchError(
                f"{log} has {len(blocks)} runs and {named[0][0].index} names {len(named)}; one of them is cut short"
            )
        shifted = logged(source, log, FIRST, SHIFTED) if SHIFTED in source.text(log).partition("\n")[0] else blocks
        for position, ((data, entry), block, other) in enumerate(zip(named, blocks, shifted, strict=True), start=1):
            where = f"{log}, run {position},"
            yield _run(data, names[data.index.parent, data.algorithm], entry, block, other, where)

    yield from reading.each(by_log, runs_of)


def _index(source: Source, file: PurePosixPath) -> Iterator[_Data]:
    data: _Data | None = None
    for number, line in enumerate(source.text(file).splitlines(), start=1):
        text, where = line.strip(), f"{file}, line {number},"
        if not text or text.startswith("%"):
            continue
        if "funcId" in text and "=" in text.partition(",")[0]:
            if data is not None:
                yield _whole(data)
            data = _head(text, where, file, number)
        elif data is None:
            raise BenchError(f"{where} is no index of IOHprofiler: it must begin with the function and dimension")
        else:
            _entries(text, where, data)
    if data is None:
        raise BenchError(f"{file} is empty, and no index of IOHprofiler")
    yield _whole(data)


def _whole(data: _Data) -> _Data:
    if not data.entries:
        raise BenchError(f"{data.index}, line {data.line}, names no run; the index is cut short")
    return data


def _head(text: str, where: str, file: PurePosixPath, line: int) -> _Data:
    pairs = {key: (one or other or plain).strip() for key, one, other, plain in _PAIR.findall(text)}
    try:
        dimension = int(pairs["DIM"])
    except (KeyError, ValueError) as error:
        raise BenchError(f"{where} has no dimension (DIM)") from error
    suite = pairs.get("suite", "")
    if pairs.get("maximization", "").upper() in ("T", "TRUE", "1") or suite.upper() == "PBO":
        raise BenchError(f"{where} is of maximisation; only minimisation can be compared here")
    algorithm = label(pairs.get("algId") or file.parent.name or "unknown", where)
    function = label(pairs.get("funcId"), where)
    return _Data(file, line, suite, function, pairs.get("funcName", ""), dimension, algorithm)


def _entries(text: str, where: str, data: _Data) -> None:
    """Add the log and the runs of a line; a long list may go on over several lines."""
    for item in filter(None, (each.strip() for each in text.split(","))):
        if found := _ENTRY.fullmatch(item):
            try:
                entry = Logged(int(found[1]), int(found[2]), float(found[3]))
            except ValueError as error:
                raise BenchError(f"{where} has the run {shown(item)}, which cannot be read") from error
            if not data.log.name:
                raise BenchError(f"{where} names a run before its log: {shown(item)}")
            if entry.evaluations:  # a problem that was reset before its first evaluation has no rows
                data.entries.append(entry)
        elif not data.log.name and item.endswith(SUFFIXES):
            data.log = PurePosixPath(item.replace("\\", "/"))
            if data.log.is_absolute() or ".." in data.log.parts:
                raise BenchError(f"{where} names {shown(item)}, which is outside the folder")
        else:
            raise BenchError(f"{where} has {shown(item)} where a run such as '1:301|8.5e-02' is expected")


def _log_of(source: Source, data: _Data) -> PurePosixPath:
    log = data.index.parent / data.log
    return next((each for each in map(log.with_suffix, SUFFIXES) if each in source.files), log)


def _run(data: _Data, algorithm: str, entry: Logged, block: Block, shifted: Block, where: str) -> Run:
    function = int(data.function) if data.function.isdigit() else data.function
    problem, lacking = problem_of(data.suite, function, data.name, data.dimension, entry.instance, data.index)
    evaluations, values = block
    if not len(values):
        raise BenchError(f"{where} has no evaluation; the log may be cut short")
    if (rises := np.flatnonzero(np.diff(values) > 0)).size:
        raise BenchError(
            f"{where} has a best value that rises with evaluation {evaluations[int(rises[0]) + 1]}: it is of "
            "maximisation, and only minimisation can be compared here"
        )
    _require_whole(entry, values[-1], [values[-1], shifted[1][-1], values[-1] + lacking], where)
    if lacking and shifted is not block:
        _require_optimum(float(values[-1]), float(shifted[1][-1]), lacking, problem, where)
    trace = improvements(evaluations, values + lacking)
    return Run(problem, algorithm, data.dimension, max(entry.evaluations, int(evaluations[-1])), trace)


def _require_whole(entry: Logged, last: float, best: list[float], where: str) -> None:
    """Refuse a run whose best value is not the final one of the index, which has at least five digits."""
    near = 1e-5 * abs(entry.final) + 1e-9
    if not any(abs(each - entry.final) <= near or each == entry.final for each in best):
        raise BenchError(
            f"{where} ends at {last!s} and its index has {entry.final!r}; one of them is cut short or of another run"
        )


def _require_optimum(value: float, shifted: float, optimum: float, problem: str, where: str) -> None:
    """Refuse another f_opt than this project's; logs may have six digits of each value."""
    if abs(shifted - value - optimum) > 2e-5 * max(1.0, abs(value), abs(shifted)):
        raise BenchError(
            f"{where} has f_opt = {shifted - value:g} for {problem}, whose optimum is {optimum!r} here; the data are "
            "of another function or instance"
        )
