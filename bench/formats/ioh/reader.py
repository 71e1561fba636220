"""Read the format of IOHprofiler: a JSON file about the runs on a function, and logs (``.dat``) of each dimension.

``raw_y`` is the objective value, except in the suites BBOB and SBOX, where it is the value less f_opt. Loggers write it
with ten decimals, and the best value of a run with all digits into the JSON file, from where the last improvement is
taken.

Source: J. de Nobel, F. Ye, D. Vermetten, H. Wang, C. Doerr, T. Bäck, "IOHexperimenter: Benchmarking Platform for
Iterative Optimization Heuristics", Evolutionary Computation 32(3), 2024.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import PurePosixPath
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.contract.numbers import is_finite, is_whole
from bench.contract.objective import Trace
from bench.contract.typing import Floats
from bench.formats import naming
from bench.formats.ioh.writer import BBOB, F_OPT
from bench.formats.runs import (
    FormatReader,
    ImportedRun,
    Reading,
    evaluation,
    improvements,
    inside,
    label,
    optimizer_labels,
    quoted,
    require_increasing,
)
from bench.formats.source import Source
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject, parse_json
from bench.trial.columns import Row

FIRST, VALUE = "evaluations", "raw_y"
DECIMALS = 1e-9  # to which a log and the JSON file of a run must agree

SBOX = "sbox-cost"
"""The suite SBOX-COST, whose logs name its functions as those of bbob are named; their f_opt are the same."""

_GUESSED = "The logs name no suite; functions with the numbers and names of bbob's are taken for those of {}."

_COLUMN = re.compile(r'"([^"]*)"|(\S+)')
_UNNAMED = ("", "unknown_suite", "unknown suite", "no suite")

Block = tuple[NDArray[np.int64], Floats]


class _Data(NamedTuple):
    """A dimension of a JSON file."""

    file: PurePosixPath
    head: JsonObject
    algorithm: str
    dimension: int
    log: PurePosixPath
    runs: list[JsonObject]


def is_index(source: Source, file: PurePosixPath) -> bool:  # noqa: ARG001 - as of every format
    """Return whether a file is one of IOHprofiler about runs, by its name."""
    return file.name.startswith("IOHprofiler") and file.suffix == ".json"


def runs(source: Source, indices: Sequence[PurePosixPath], reading: Reading) -> Iterator[ImportedRun]:
    """Yield the runs of every JSON file, log by log.

    Raises:
        BenchError: for a file that is no data of IOHprofiler or is cut short, and for results of maximisation.
    """
    scenarios = list(reading.each(indices, partial(_scenarios, source)))
    unnamed = [
        data
        for data in scenarios
        if _is_guessed(data.head.get("suite"), data.head["function_id"], data.head.get("function_name"))
    ]
    if unnamed:
        suite = "bbob" if all(map(_is_bbob, unnamed)) else SBOX
        reading.notes.append(_GUESSED.format(suite))
        for data in unnamed:
            data.head["suite"] = suite
    names = optimizer_labels(
        (data.file.parent, data.algorithm, (data.head["function_id"], data.dimension)) for data in scenarios
    )

    def runs_of(data: _Data) -> Iterator[ImportedRun]:
        blocks = _logged(source, data.log, data.file, len(data.runs))
        for position, (run, block) in enumerate(zip(data.runs, blocks, strict=True), start=1):
            yield _run(data, names[data.file.parent, data.algorithm], run, block, f"{data.log}, run {position},")

    yield from reading.each(scenarios, runs_of)


def _scenarios(source: Source, file: PurePosixPath) -> Iterator[_Data]:
    try:
        head = parse_json(source.text(file))
    except ValueError as error:
        raise BenchError(f"{file} is no JSON, or is cut short: {error}") from error
    try:
        if head["maximization"]:
            raise BenchError(f"{file} holds results of maximisation; only minimisation can be compared here")
        algorithm = label(head["algorithm"]["name"], str(file))
        for scenario in head["scenarios"]:
            log = inside(file.parent, scenario["path"], str(file))
            numbers = int(head["function_id"]), int(scenario["dimension"])
            runs = [{"instance": int(run["instance"]), "evals": int(run["evals"]), **run} for run in scenario["runs"]]
            yield _Data(file, head | {"function_id": numbers[0]}, algorithm, numbers[1], log, runs)
    except BenchError:
        raise
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as error:
        what = f"lacks {error}" if isinstance(error, KeyError) else f"has a value of another kind ({error})"
        raise BenchError(f"{file} is no file of IOHprofiler: it {what}") from error


def _logged(source: Source, log: PurePosixPath, index: PurePosixPath, number: int) -> list[Block]:
    """Return evaluations and values of each run of a log; a line of the names of columns begins a run.

    Raises:
        BenchError: for a log that is missing, is cut short, lacks the column ``raw_y``, or has another number of runs
            than its index names.
    """
    if log not in source.files:
        raise BenchError(f"the log {log} is missing, which its index names")
    text = source.text(log)
    lines = text.splitlines()
    if lines and not text.endswith("\n"):
        raise BenchError(f"{log} is cut short in line {len(lines)}: {quoted(lines[-1])}")
    blocks: list[Block] = []
    columns: list[str] = []
    rows: list[tuple[int, float]] = []
    begin = 1
    for place, line in enumerate([*lines, FIRST], start=1):
        cells = line.split()
        if not cells:
            continue
        if line.lstrip(' "').startswith(FIRST):
            if columns:
                blocks.append(_block(rows, log, begin))
            columns = [quoted or plain for quoted, plain in _COLUMN.findall(line)]
            rows, begin = [], place + 1
            if place <= len(lines) and VALUE not in columns:
                raise BenchError(f"{log}, line {place}, has no column {VALUE!r}")
            continue
        try:
            rows.append((evaluation(cells[0]), float(cells[columns.index(VALUE)])))
        except (ValueError, IndexError) as error:
            raise BenchError(f"{log}, line {place}, is no row of evaluations and values: {quoted(line)}") from error
    if len(blocks) != number:
        raise BenchError(f"{log} has {len(blocks)} runs and {index} names {number}; one of them is cut short")
    return blocks


def _block(rows: list[tuple[int, float]], log: PurePosixPath, begin: int) -> Block:
    evaluations = np.array([row[0] for row in rows], dtype=np.int64)
    values = np.array([row[1] for row in rows], dtype=np.float64)
    require_increasing(evaluations, range(begin, begin + len(rows)), str(log))
    if np.isnan(values).any():
        raise BenchError(f"{log}, line {begin + int(np.flatnonzero(np.isnan(values))[0])}, has no value")
    return evaluations, values


def _run(data: _Data, algorithm: str, run: JsonObject, block: Block, where: str) -> ImportedRun:
    exported = "trial" in run and "seed" in run  # this package's export
    name = str(data.head.get("function_name", ""))
    if exported and F_OPT not in run:  # of no suite
        problem, less = label(name, str(data.file)), 0.0
    else:
        function = data.head["function_id"]
        problem, less = _problem_of(data.head.get("suite"), function, name, data.dimension, run["instance"], data.file)
        less = float(run[F_OPT]) if exported else less
    trace = _exact(improvements(*block), run.get("best") or {}, where)
    trace = improvements(trace.evaluations, trace.values + less)
    last = int(block[0][-1]) if len(block[0]) else 0
    columns: Row = {"x": _point(run.get("best") or {}, problem)}
    if exported and is_whole(run["seed"]):
        columns["seed"] = run["seed"]
    number = run["trial"] if exported and is_whole(run["trial"]) and run["trial"] >= 0 else None
    return ImportedRun(problem, algorithm, data.dimension, max(run["evals"], last), trace, number, columns)


def _is_bbob(data: _Data) -> bool:
    """Return whether the first run's best value is that of bbob at its best point, or nothing shows the contrary."""
    run = data.runs[0] if data.runs else {}
    best = run.get("best") or {}
    x, y = best.get("x"), best.get("y")
    if y is None or not is_finite(y) or not isinstance(x, list) or not all(map(is_finite, x)):
        return True
    problem = naming.problem_name("bbob", data.head["function_id"], data.dimension, run["instance"])
    value, optimum = naming.value(problem, x), naming.known(problem).optimum
    return value is None or optimum is None or math.isclose(value - optimum, y, rel_tol=1e-6, abs_tol=1e-6)


def _is_guessed(suite: object, function: int, name: object) -> bool:
    """Return whether a function is known as one of bbob's by its number and name alone, as no suite is named."""
    unnamed = str(suite or "").strip().lower() in _UNNAMED
    return unnamed and 1 <= function <= len(BBOB) and BBOB[function - 1].lower() == str(name).lower()


def _problem_of(
    suite: object, function: int, name: str, dimension: int, instance: int, file: PurePosixPath
) -> tuple[str, float]:
    """Return the label of a problem, and what its raw values lack: f_opt of bbob and SBOX-COST, 0 of others.

    Raises:
        BenchError: where f_opt cannot be looked up.
    """
    named = str(suite or "").strip()
    shifted = {"bbob": "bbob", "sbox": SBOX, SBOX: SBOX}.get(named.lower())
    if shifted is None:
        return naming.problem_name(named or name, function, dimension, instance, name), 0.0
    for tried in (dimension, 2):  # in other dimensions than COCO's, f_opt is the same
        optimum = naming.known(naming.problem_name("bbob", function, tried, instance)).optimum
        if optimum is not None:
            return naming.problem_name(shifted, function, dimension, instance), optimum
    raise BenchError(
        f"{file} holds values less f_opt, which cannot be looked up for {shifted}; install it with: pip install "
        "'backlash-bench[suites]'"
    )


def _exact(trace: Trace, best: JsonObject, where: str) -> Trace:
    """Return a trace that ends at the best value as the JSON file has it; refuse a log that ends before it."""
    y = best.get("y")
    if not is_finite(y):
        return trace
    last = float(trace.values[-1]) if len(trace.values) else math.inf
    near = DECIMALS * max(1.0, abs(float(y)))
    if last > float(y) + near:
        raise BenchError(f"{where} ends at {last!r} and its JSON file has {y!r}; the log is cut short")
    if last < float(y) - near:
        raise BenchError(f"{where} has {last!r}, which is below the best value of its JSON file, {y!r}")
    return improvements(trace.evaluations, np.append(trace.values[:-1], float(y)))


def _point(best: JsonObject, problem: str) -> dict[str, float]:
    """Return the best point by variable, empty where the file has none."""
    x = best.get("x")
    if not isinstance(x, list) or not x:
        return {}
    names = naming.known(problem).variables
    names = names if len(names) == len(x) else tuple(f"x{number}" for number in range(1, len(x) + 1))
    return {name: float(value) if is_finite(value) else math.nan for name, value in zip(names, x, strict=True)}


READER = FormatReader("one of IOHprofiler (.json)", is_index, runs)
