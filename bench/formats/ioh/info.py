"""Read the format that IOHprofiler wrote before its JSON files: an index (``IOHprofiler_*.info``) and logs.

The index is like COCO's (:mod:`bench.formats.index`). A line of quoted columns begins each run of a log. The column
``best-so-far f(x)`` is the value before the instance shifts and scales it; in the suite BBOB it is the value less
f_opt. Where only evaluations with another trigger were logged, the log is ``.cdat`` or ``.tdat``. An old index counts
the evaluations of a run, a newer one those until its best value; the logs end at the last evaluation.

Source: IOHanalyzer's description of its formats, https://iohprofiler.github.io/IOHanalyzer/data (C. Doerr, H. Wang,
F. Ye, S. van Rijn, T. Bäck, "IOHprofiler: A Benchmarking and Profiling Tool for Iterative Optimization Heuristics",
arXiv:1810.05281), and the logs of IOHexperimenter 0.3.2.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import PurePosixPath

import numpy as np

from bench.errors import BenchError
from bench.formats.index import Logged, LoggedRuns, algorithm_labels, by_log, data_sets
from bench.formats.ioh.reader import GUESSED, Block, is_guessed, logged, problem_of
from bench.formats.runs import FormatReader, ImportedRun, Reading, improvements
from bench.formats.source import Source

VALUE = "best-so-far f(x)"
SHIFTED = "best af(x)+b"
FIRST = "function evaluation"
SUFFIXES = (".dat", ".cdat", ".tdat")

_ENTRY = re.compile(r"(\d+):(\d+)\|([^;]+)(?:;.*)?")


def is_index(source: Source, file: PurePosixPath) -> bool:  # noqa: ARG001 - as of every format
    """Return whether a file is an index of this format, by its name."""
    return file.suffix == ".info" and file.name.startswith("IOHprofiler")


def runs(source: Source, indices: Sequence[PurePosixPath], reading: Reading) -> Iterator[ImportedRun]:
    """Yield the runs of every index, log by log.

    Raises:
        BenchError: for an index or a log that is none or is cut short, and for results of maximisation.
    """
    sets = list(reading.each(indices, partial(_indexed, source)))
    if any(data.function.isdecimal() and is_guessed(data.suite, int(data.function), _name(data)) for data in sets):
        reading.notes.append(GUESSED.format("bbob"))
    names, named = algorithm_labels(sets), by_log(sets)

    def runs_of(log: PurePosixPath) -> Iterator[ImportedRun]:
        entries = [(data, entry) for data, entry in named[log] if entry.evaluations]  # without one, a run has no rows
        file = next((path for path in map(log.with_suffix, SUFFIXES) if path in source.files), log)
        read = partial(logged, source, file, FIRST, index=named[log][0][0].index, number=len(entries))
        blocks = read(VALUE)
        shifted = read(SHIFTED) if SHIFTED in source.text(file).partition("\n")[0] else blocks
        for position, ((data, entry), block, shifted_block) in enumerate(
            zip(entries, blocks, shifted, strict=True), start=1
        ):
            where = f"{file}, run {position},"
            yield _run(data, names[data.index.parent, data.algorithm], entry, block, shifted_block, where)

    yield from reading.each(named, runs_of)


def _indexed(source: Source, file: PurePosixPath) -> Iterator[LoggedRuns]:
    """Yield the data sets of an index; raises BenchError for results of maximisation."""
    for data in data_sets(source, file, "IOHprofiler", _ENTRY):
        if data.keys.get("maximization", "").upper() in ("T", "TRUE", "1") or data.suite.upper() == "PBO":
            raise BenchError(f"{data.where} is of maximisation; only minimisation can be compared here")
        yield data


def _name(data: LoggedRuns) -> str:
    """Return the name of a function, which the first version of the format does not have."""
    return data.keys.get("funcName", "")


def _run(data: LoggedRuns, algorithm: str, entry: Logged, block: Block, shifted: Block, where: str) -> ImportedRun:
    function = int(data.function) if data.function.isdecimal() else data.function
    problem, lacking = problem_of(data.suite, function, _name(data), data.dimension, entry.instance, data.index)
    evaluations, values = block
    if not len(values):
        raise BenchError(f"{where} has no evaluation; the log may be cut short")
    if (rises := np.flatnonzero(np.diff(values) > 0)).size:
        raise BenchError(
            f"{where} has a best value that rises with evaluation {evaluations[int(rises[0]) + 1]}: it is of "
            "maximisation, and only minimisation can be compared here"
        )
    _require_whole(entry.final or 0.0, values[-1], [values[-1], shifted[1][-1], values[-1] + lacking], where)
    if lacking and shifted is not block:
        _require_optimum(float(values[-1]), float(shifted[1][-1]), lacking, problem, where)
    trace = improvements(evaluations, values + lacking)
    return ImportedRun(problem, algorithm, data.dimension, max(entry.evaluations or 0, int(evaluations[-1])), trace)


def _require_whole(final: float, last: float, best: list[float], where: str) -> None:
    """Refuse a run whose best value is not the final one of the index, which has at least five digits."""
    near = 1e-5 * abs(final) + 1e-9
    if not any(abs(value - final) <= near or value == final for value in best):
        raise BenchError(
            f"{where} ends at {last!s} and its index has {final!r}; one of them is cut short or of another run"
        )


def _require_optimum(value: float, shifted: float, optimum: float, problem: str, where: str) -> None:
    """Refuse another f_opt than this project's; logs may have six digits of each value."""
    if abs(shifted - value - optimum) > 2e-5 * max(1.0, abs(value), abs(shifted)):
        raise BenchError(
            f"{where} has f_opt = {shifted - value:g} for {problem}, whose optimum is {optimum!r} here; the data are "
            "of another function or instance"
        )


READER = FormatReader("one of IOHprofiler before JSON (.info)", is_index, runs)
