r"""Read the format of COCO: an index of runs (``.info``), and logs of each data set (``.dat``, ``.tdat``).

The archives of 2009 write exponents of three digits and no suite into the index (:mod:`bench.formats.coco.index`), and
the final value less the precision of 1e-8; later ones name the suite. In every version the first column of a log is the
number of evaluations of the objective, and the third the best noise-free value less f_opt, which is in the
header of each run.

A run's trace joins the improvements of both logs; the times of COCO's targets are those of the ``.dat`` file. The
logged points have four decimals and are left out.

Source: N. Hansen, A. Auger, R. Ros, O. Mersmann, T. Tušar, D. Brockhoff, "COCO: a platform for comparing continuous
optimizers in a black-box setting", Optimization Methods and Software 36(1), 2021.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import PurePosixPath
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.contract.typing import Floats
from bench.formats import naming
from bench.formats.coco.index import Logged, LoggedRuns, algorithm_labels, by_log, data_sets
from bench.formats.coco.writer import STAND_IN
from bench.formats.runs import FormatReader, ImportedRun, Reading, improvements, label, quoted, require_increasing
from bench.formats.source import Source
from bench.helpers.errors import BenchError
from bench.helpers.text import joined

INFINITE = 1e21
"""COCO writes 3e21 for infinity; no finite difference is as large."""

EQUAL = 1e-6  # to which a logged value may equal a target
DIGITS = 1e-9  # to which COCO's own logger prints a value; both are relative

TARGETS = np.power(10, np.arange(-40, 11) / 5)
"""COCO's precisions, 1e-8 to 1e2, five a decade."""

NOISY = 101  # the first function of bbob-noisy, in indices that name no suite
_SEVERAL_OBJECTIVES = re.compile(r"\bsuite\s*=\s*'[^']*biobj|\bindicator\s*=")
_FOPT = re.compile(r"Fopt\s*\(([^)]*)\)")


class Block(NamedTuple):
    """The rows of one run in a log."""

    header: str
    line: int  # of the header
    evaluations: NDArray[np.int64]
    values: Floats  # best-so-far value less f_opt


def is_index(source: Source, file: PurePosixPath) -> bool:  # noqa: ARG001 - as of every format
    """Return whether a file is an index of COCO, by its name."""
    return file.suffix == ".info" and not file.name.startswith("IOHprofiler")


def runs(source: Source, indices: Sequence[PurePosixPath], reading: Reading) -> Iterator[ImportedRun]:
    """Yield the runs of every index, log by log.

    Raises:
        BenchError: for an index or a log that is no COCO data, is cut short, or has another f_opt than this project,
            and for results of several suites or with several objectives.
    """
    sets = list(reading.each(indices, partial(indexed, source)))
    if len(suites := sorted({data.suite for data in sets})) > 1:
        raise BenchError(
            f"{source.name} holds results of {len(suites)} suites, {joined(suites)}; import the folder of one at a time"
        )
    names, named = algorithm_labels(sets), by_log(sets)
    unfinished, longer = 0, 0

    def runs_of(log: PurePosixPath) -> Iterator[ImportedRun]:
        nonlocal unfinished, longer
        for data, entry, one, timed in _blocks(source, log, named[log]):
            yield _run(data, names[data.index.parent, data.algorithm], log, entry, one, timed)
            unfinished += entry.evaluations is None
            if timed is not None and entry.evaluations is not None:
                longer += int(one.evaluations[-1] > timed.evaluations[-1])

    yield from reading.each(named, runs_of)
    if unfinished:
        reading.notes.append(f"Runs that were not finished, of which what they logged is imported: {unfinished}.")
    if longer:
        reading.notes.append(f"Runs that go on in the .dat file beyond their end in index and .tdat file: {longer}.")


def indexed(source: Source, file: PurePosixPath) -> Iterator[LoggedRuns]:
    """Yield the data sets of an index; their functions are numbers, and each has a suite."""
    if _SEVERAL_OBJECTIVES.search(source.text(file).lstrip().partition("\n")[0]):
        raise BenchError(f"{file} is an index of bi-objective results, which are not supported")
    for data in data_sets(source, file):
        if not data.function.isdecimal():
            raise BenchError(f"{data.where} has no number of the function or dimension")
        data.suite = label(data.suite or ("bbob" if int(data.function) < NOISY else "bbob-noisy"), data.where)
        yield data


def _blocks(
    source: Source, log: PurePosixPath, named: list[tuple[LoggedRuns, Logged]]
) -> Iterator[tuple[LoggedRuns, Logged, Block, Block | None]]:
    """Yield the named runs as both logs have them; there may be no .tdat file, else it must have as many runs."""
    if log not in source.files:
        raise BenchError(f"the log {log} is missing, which the index names")
    blocks, timed = logged(source, log), log.with_suffix(".tdat")
    timed_blocks = logged(source, timed) if timed in source.files else [None] * len(blocks)
    if len(timed_blocks) != len(blocks):
        raise BenchError(f"{log} has {len(blocks)} runs and {timed} has {len(timed_blocks)}; one of them is cut short")
    if len(blocks) < len(named):
        data, entry = named[len(blocks)]
        raise BenchError(f"{log} ends before the run on instance {entry.instance} that {data.index} names")
    if len(blocks) > len(named):
        raise BenchError(f"{log}, line {blocks[len(named)].line}, begins a run that no index names")
    for (data, entry), one, timed_block in zip(named, blocks, timed_blocks, strict=True):
        if timed_block is not None:
            _require_rows(entry, one, timed_block, log, last=one is blocks[-1])
        yield data, entry, one, timed_block


def _require_rows(entry: Logged, one: Block, timed: Block, log: PurePosixPath, *, last: bool) -> None:
    """Refuse a run of which one log lacks the end: .dat where .tdat reaches a further target, .tdat at its ``last``."""
    ends = f"is cut short: its run on instance {entry.instance}"
    if last and timed.evaluations[-1] < min(one.evaluations[-1], entry.evaluations or np.inf):
        raise BenchError(
            f"{log.with_suffix('.tdat')} {ends} ends at evaluation {timed.evaluations[-1]}, and that of its .dat file "
            f"at {one.evaluations[-1]}"
        )
    later = timed.evaluations > one.evaluations[-1]
    if (lost := np.flatnonzero(later & (timed.values < _next_target(one.values.min()) * (1 - EQUAL)))).size:
        raise BenchError(
            f"{log} {ends} lacks evaluation {timed.evaluations[lost[0]]}, with which its .tdat file reaches "
            f"{timed.values[lost[0]]:.3g}"
        )


def _joined(one: Block, timed: Block, optimum: float) -> Block:
    """Return a run with the rows of both logs.

    The .dat file says when a target of COCO was reached, as for cocopp. Where the .tdat file has one earlier, the value
    equals the target in the ten digits that are printed and was just above it. So it is here, also beside f_opt.
    """
    best = np.append(np.inf, np.minimum.accumulate(one.values))
    until = best[np.searchsorted(one.evaluations, timed.evaluations, side="right")]
    evaluations = np.concatenate((one.evaluations, timed.evaluations))
    above = _next_target(until) * (1 + DIGITS) + 2 * np.spacing(abs(optimum))
    values = np.concatenate((one.values, np.maximum(timed.values, above)))
    order = np.lexsort((values, evaluations))
    evaluations, values = evaluations[order], values[order]
    first = np.append(True, evaluations[1:] > evaluations[:-1])[: len(values)]
    return Block(one.header, one.line, evaluations[first], values[first])


def _next_target(values: Floats | np.float64) -> Floats:
    """Return the easiest of COCO's targets that each value does not reach yet, -inf beyond the last."""
    return np.append(-np.inf, TARGETS)[np.searchsorted(TARGETS, values)]


def logged(source: Source, file: PurePosixPath) -> list[Block]:
    """Return the runs of a log, each with its header; raises BenchError with the line that cannot be read."""
    blocks: list[Block] = []
    text = source.text(file)
    lines = text.splitlines()
    header = ""
    begin = 0
    rows: list[tuple[int, str, str]] = []
    for number, line in enumerate(lines, start=1):
        if line.startswith("%"):
            if header and not rows:
                header += line  # a header may have several lines
                continue
            if header:
                blocks.append(_block(header, begin, rows, file))
            header, begin, rows = line, number, []
        elif line.strip():
            cells = line.split(None, 3)
            if not header or len(cells) < 3:
                what = "is cut short" if header else "comes before the header of a run"
                raise BenchError(f"{file}, line {number}, {what}: {quoted(line)}")
            rows.append((number, cells[0], cells[2]))
    if header:
        blocks.append(_block(header, begin, rows, file))
    if lines and not text.endswith(("\n", "\r")) and _is_cut(lines[-2:]):
        raise BenchError(f"{file} is cut short in line {len(lines)}: {quoted(lines[-1])}")
    return blocks


def _is_cut(lines: list[str]) -> bool:
    """Return whether the last of two lines, which has no end, has fewer or shorter cells than the one before it."""
    before, last = (line.split() for line in lines) if len(lines) > 1 else ([], [""])
    return len(last) != len(before) or len(last[-1].lstrip("+-")) < len(before[-1].lstrip("+-"))


def _block(header: str, begin: int, rows: list[tuple[int, str, str]], file: PurePosixPath) -> Block:
    """Return the run of a header and its rows, each a line's number and its texts of evaluations and value."""
    if not rows:
        raise BenchError(f"{file}, line {begin}, begins a run without an evaluation; the file may be cut short")
    places, counts, values = zip(*rows, strict=True)
    try:
        evaluations, best = np.array(counts).astype(np.float64), np.array(values).astype(np.float64)
    except ValueError:
        for number, *cells in rows:
            if not all(map(_is_number, cells)):
                raise BenchError(f"{file}, line {number}, has {quoted(' … '.join(cells))}, no numbers") from None
        raise
    whole = evaluations.astype(np.int64)
    if not (whole == evaluations).all():
        at = int(np.flatnonzero(whole != evaluations)[0])
        raise BenchError(f"{file}, line {places[at]}, has {quoted(counts[at])} evaluations, no whole number")
    best[np.isnan(best)] = np.inf  # an objective that failed
    require_increasing(whole, places, str(file), repeats=True)
    twice = np.flatnonzero((np.diff(whole) == 0) & (np.diff(best) != 0))
    if len(twice):
        raise BenchError(
            f"{file}, line {places[int(twice[0]) + 1]}, repeats evaluation {whole[twice[0]]} with another value"
        )
    return Block(header, begin, whole, best)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _run(
    data: LoggedRuns, algorithm: str, log: PurePosixPath, entry: Logged, one: Block, timed: Block | None
) -> ImportedRun:
    of_suite = not data.comment.startswith(STAND_IN)
    where = f"{log}, line {one.line},"
    if of_suite:
        problem = naming.problem_name(data.suite, int(data.function), data.dimension, entry.instance)
    else:
        problem = label(data.comment.removeprefix(STAND_IN), where)
    optimum = _optimum(problem, one.header, where, of_suite=of_suite)
    block = one if timed is None else _joined(one, timed, optimum)
    last = int(block.evaluations[-1])
    _require_whole(entry, block, log)
    finite = block.values < INFINITE
    trace = improvements(block.evaluations[finite], block.values[finite] + optimum)
    return ImportedRun(problem, algorithm, data.dimension, max(last, entry.evaluations or 0), trace)


def _optimum(problem: str, header: str, where: str, *, of_suite: bool) -> float:
    """Return f_opt: the family's, with all its digits, where the header's agrees with it."""
    match = _FOPT.search(header)
    if match is None or not _is_number(match[1]):
        raise BenchError(f"{where} is the header of a run without its f_opt: {quoted(header)}")
    optimum = naming.known(problem).optimum if of_suite else None
    if optimum is None:
        return float(match[1])
    if not naming.agrees(match[1], optimum):
        raise BenchError(
            f"{where} has f_opt = {match[1]} for {problem}, whose optimum is {optimum!r} here; the data are of another "
            "function or instance"
        )
    return optimum


def _require_whole(entry: Logged, block: Block, log: PurePosixPath) -> None:
    """Refuse a run whose logs end before the evaluations and at a worse value than the index names.

    Indices of 2009 have the final value less the precision of 1e-8, to two digits.
    """
    if entry.evaluations is None or entry.final is None or block.evaluations[-1] >= entry.evaluations:
        return
    best = float(block.values.min())
    if best > entry.final + 0.06 * abs(entry.final) + 2e-8:
        raise BenchError(
            f"{log} is cut short: its run on instance {entry.instance} ends at evaluation {block.evaluations[-1]} and "
            f"{best:.1e}, and the index names {entry.evaluations} and {entry.final:.1e}"
        )


READER = FormatReader("an index of COCO (.info)", is_index, runs)
