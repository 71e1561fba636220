"""Read a published table of results: a row or a column for each optimizer, numbers with the digits that were printed.

A CSV file may begin with comment lines that are TOML and hold what is the same in all rows (``# runs = 30``), the
source, and which problem or optimizer a printed name means. Without a column of optimizers, each column that is not
known is one, with cells such as ``1.2 ± 0.3``.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import NamedTuple

from bench.contract.numbers import is_finite, require_positive
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject, parse_toml, read_text
from bench.helpers.text import printable
from bench.study.budget import Budget

WORDS = {
    "suite": "suite benchmark testsuite",
    "function": "function f fid func functions testfunction problem dataset",
    "instance": "instance",
    "dimension": "dimension dim d",
    "budget": "budget evaluations fes maxfes nfe maxevaluations functionevaluations",
    "runs": "runs n trials repetitions numberofruns",
    "optimizer": "optimizer algorithm alg method optimiser solver",
    "statistic": "statistic metric measure index",
    "mean": "mean avg average ave meanvalue",
    "sd": "sd std stdev stddev standarddeviation",
    "best": "best min minimum",
    "median": "median med",
    "worst": "worst max maximum",
    "rank": "rank",
    "success": "success successes successrate sr",
}
"""What headers are called, by column: in lower case, letters and digits alone."""

COLUMNS = {word: column for column, words in WORDS.items() for word in words.split()}
STATISTICS = ("mean", "sd", "best", "median", "worst", "rank", "success")
CONSTANT = ("suite", "instance", "dimension", "budget", "runs", "optimizer")
KEYS = (*CONSTANT, "source", "values", "zero", "lowest", "counts", "problem", "constraints", "functions", "optimizers")
AVERAGES = frozenset(["average", "avg", "mean", "averagerank", "avgrank", "averank", "meanrank", "overall"])
NEAR = 1e-10
"""The relative size of what rounding makes of a number, in their code or ours."""

MISSING = frozenset(["", "-", "--", "–", "—", "na", "n/a", "nan", "none"])


class Printed(NamedTuple):
    """A printed number, and a unit of its last digit, as some round and some cut; 0.00E+00 is exactly 0."""

    value: float
    unit: float
    text: str

    @property
    def low(self) -> float:
        """The smallest number that is printed so."""
        return self.value - self.unit - NEAR * abs(self.value)

    @property
    def high(self) -> float:
        """The largest number that is printed so."""
        return self.value + self.unit + NEAR * abs(self.value)


@dataclass(frozen=True, eq=False)
class PaperCell:
    """The printed numbers of an optimizer on a function, by statistic, and the ``reasons`` of those that are missing.

    Attributes:
        line: its line in the file.
        key: suite, function, dimension, budget and optimizer as printed; in a table each occurs once.
        suite, function, optimizer: as printed.
        dimension, instance, runs: None where they are not printed or no whole numbers.
        budget: as printed, such as ``"1e4 * d"``.
    """

    line: int
    suite: str
    function: str
    optimizer: str
    dimension: int | None
    instance: int | None
    runs: int | None
    budget: str
    numbers: Mapping[str, Printed]
    reasons: Mapping[str, str]

    @property
    def key(self) -> tuple[object, ...]:
        """The identity of the cell in its table."""
        return self.suite, self.function, self.dimension, self.instance, self.budget, self.optimizer

    @property
    def where(self) -> str:
        """The cell in words, such as ``"f12, d = 10, jSO (line 7)"``."""
        function = f"f{self.function}" if self.function.isdigit() else self.function
        size = f", d = {self.dimension}" if self.dimension else ""
        return f"{function}{size}, {self.optimizer} (line {self.line})"

    @property
    def average(self) -> bool:
        """Whether its row prints averages over functions."""
        return plain(self.function) in AVERAGES

    def evaluations(self, dimension: int) -> int | None:
        """Return the evaluations of a run, None where the table does not print them; raises BenchError for text."""
        text = re.sub(r"(?<=\d)[.,_](?=\d{3}\b)", "", self.budget.lower())
        text = re.sub(r"^([\d.e+]+)\s*[x×*]?\s*d$", r"\1 * d", text)
        number = re.fullmatch(r"[\d.]+(e\+?\d+)?", text)
        budget = Budget.read(int(float(text)) if number else text, "its budget") if text else None
        return None if budget is None else budget.evaluations(dimension)


@dataclass(frozen=True)
class PaperTable:
    """A table as it was printed.

    Attributes:
        name: of its file, without the ending.
        cells: those of functions, each once.
        averages: those of rows that average over functions.
        settings: what the table's head says (:data:`KEYS`).
        notes: a sentence on each thing that was left out or could not be read.
    """

    name: str
    cells: tuple[PaperCell, ...]
    averages: tuple[PaperCell, ...] = ()
    settings: JsonObject = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def errors(self) -> bool:
        """Whether values are errors, above the optimum, and no objective values."""
        return self.settings.get("values") == "error"

    @property
    def lowest(self) -> float:
        """The lowest possible value according to the table; -inf where it names none."""
        return float(self.settings.get("lowest", 0.0 if self.errors else -math.inf))


def read(path: Path) -> PaperTable:
    """Return the table of a CSV file.

    Raises:
        BenchError: where the file cannot be read, has no columns that are known, or no cell with a number.
    """
    try:
        text = read_text(path)
    except (OSError, ValueError) as error:
        raise BenchError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    notes: list[str] = []
    settings, rows = _csv(text, str(path), notes)
    cells: dict[tuple[object, ...], PaperCell] = {}
    for cell in _cells(rows, settings, str(path), notes):
        if (first := cells.setdefault(cell.key, cell)) is not cell:
            same = "the same numbers" if first.numbers == cell.numbers else "other numbers"
            notes.append(f"{cell.where}: line {first.line} has this cell, too, with {same}; the first is used")
    notes += [f"{cell.where}: {reason}" for cell in cells.values() for reason in cell.reasons.values()]
    kept = [cell for cell in cells.values() if not cell.average]
    if not any(cell.numbers for cell in kept):
        raise BenchError(
            f"{path} has no cell with a number; a table has the columns suite, function, dimension, budget, runs, "
            "optimizer, mean and sd, or a column for each optimizer"
        )
    averages = [cell for cell in cells.values() if cell.average]
    return PaperTable(path.stem, tuple(kept), tuple(averages), settings, tuple(notes))


def plain(text: str) -> str:
    """Return a printed name in lower case, letters and digits alone."""
    return re.sub(r"[^a-z0-9]", "", text.lower())


def _known(settings: JsonObject, where: str, notes: list[str]) -> JsonObject:
    """Return the settings that are known; the others are noted."""
    notes += [f"{where}: unknown key {key!r}{nearest(key, KEYS)}" for key in settings if key not in KEYS]
    for key, known in (("values", ("objective", "error")), ("counts", (True, False))):
        if key in settings and settings[key] not in known:
            raise BenchError(f"{where}: {key} must be {' or '.join(map(repr, known))}, not {settings[key]!r}")
    if "zero" in settings:
        require_positive(f"{where}: zero", settings["zero"])
    if "lowest" in settings and not is_finite(settings["lowest"]):
        raise BenchError(f"{where}: lowest must be a number, not {settings['lowest']!r}")
    for key in ("problem", "functions", "optimizers"):
        if not isinstance(settings.get(key, {}), dict):
            raise BenchError(f"{where}: {key} must be a table, not {settings[key]!r}")
    return {key: value for key, value in settings.items() if key in KEYS}


def _csv(text: str, where: str, notes: list[str]) -> tuple[JsonObject, list[dict[str, str]]]:
    lines = text.splitlines()
    head = next((place for place, line in enumerate(lines) if not line.startswith("#")), len(lines))
    try:
        settings = _known(parse_toml("\n".join(line[1:].strip() for line in lines[:head])), where, notes)
    except ValueError as error:
        raise BenchError(f"{where}: the comment at the top must be TOML, as in '# runs = 30': {error}") from error
    if head == len(lines):
        raise BenchError(f"{where} has no header")
    separator = max(";\t,", key=lines[head].count)
    reader = csv.reader(lines[head:], delimiter=separator, skipinitialspace=True)
    names = [name.strip() for name in next(reader)]
    rows = []
    for row in reader:
        line = head + reader.line_num
        if not any(map(str.strip, row)):
            continue
        if len(row) > len(names):
            notes.append(f"line {line} has {len(row)} cells under {len(names)} headers and is left out")
            continue
        texts = {name: text.strip() for name, text in zip(names, row, strict=False)}
        if separator != ",":
            texts = {name: re.sub(r"(?<=\d),(?=\d)", ".", text) for name, text in texts.items()}
        rows.append({"line": str(line), **texts})
    return settings, rows


def _cells(rows: list[dict[str, str]], settings: JsonObject, where: str, notes: list[str]) -> Iterator[PaperCell]:
    """Yield the cells of rows, which have a column for each optimizer or one of optimizers."""
    headers = list(dict.fromkeys(header for row in rows for header in row if header != "line"))
    columns: dict[str, str] = {}
    for header in headers:
        word = plain(header)
        column = COLUMNS.get(word, COLUMNS.get(word.replace("error", "").replace("best", ""), ""))
        if column and column not in columns.values():
            columns[header] = column
            if "error" in word and column in STATISTICS:
                settings.setdefault("values", "error")
    others = [header for header in headers if header not in columns]
    wide = "optimizer" not in columns.values() and "optimizer" not in settings and "mean" not in columns.values()
    if "function" not in columns.values():
        raise BenchError(f"{where} has no column of functions; its columns are {', '.join(headers)}")
    if others and not wide:
        notes.append(f"not read: the columns {', '.join(map(repr, others))}")
    constants = {key: str(settings[key]) for key in CONSTANT if key in settings}
    merged: dict[tuple[str, ...], dict[str, str]] = {}
    before = ""
    for row in rows:
        texts = constants | {column: row[header] for header, column in columns.items() if row.get(header)}
        before = texts["function"] = texts.get("function") or before
        if not wide:
            yield _cell(row["line"], texts | _split(texts.get("mean", "")))
            continue
        statistic = COLUMNS.get(plain(texts.pop("statistic", "mean")), "")
        for header in others:
            printed = {statistic: row.get(header, "")} if statistic != "mean" else _split(row.get(header, ""))
            key = (*(texts.get(name, "") for name in ("suite", "function", "dimension")), header)
            if "statistic" in columns.values() and key in merged:
                merged[key] |= printed
            elif "statistic" in columns.values():
                merged[key] = {"line": row["line"], **texts, "optimizer": header, **printed}
            else:
                yield _cell(row["line"], texts | {"optimizer": header} | printed)
    for texts in merged.values():
        yield _cell(texts["line"], texts)


def _split(text: str) -> dict[str, str]:
    """Return mean and SD of a text such as ``"1.2 ± 0.3"``, ``"1.2 (0.3)"`` or ``"1.2"``."""
    mean, _, sd = re.sub(r"±|\+/-|\\pm|\((?=\s*\d)", "±", text).partition("±")
    return {"mean": mean.strip()} | ({"sd": sd.strip(" )")} if sd else {})


def _cell(line: str, texts: Mapping[str, str]) -> PaperCell:
    numbers: dict[str, Printed] = {}
    reasons: dict[str, str] = {}
    for name in STATISTICS:
        given = texts.get(name, "").strip()
        text = re.sub(r"(?<=[\d.])\s*[-+≈=*†‡§~]+$", "", given).replace("−", "-").replace(" ", "")
        if text.lower() in MISSING:
            continue
        try:
            decimal = Decimal(text.rstrip("%"))
            exponent = int(decimal.as_tuple().exponent)  # raises for NaN and infinity
        except (InvalidOperation, ValueError):
            reasons[name] = f"{printable(given, 40)!r} as {name} is no number"
            continue
        exact = decimal == 0 and "e" in text.lower()
        numbers[name] = Printed(float(decimal), 0.0 if exact else 10.0**exponent, text)
    wholes: dict[str, int | None] = {}
    for name in ("dimension", "instance", "runs"):
        text = re.sub(r"(?<=\d)[.,](?=\d{3}\b)", "", texts.get(name, ""))
        wholes[name] = int(text) if re.fullmatch(r"0*[1-9]\d{0,8}", text) else None
        if wholes[name] is None and text.lower() not in MISSING:
            reasons[name] = f"{printable(text, 40)!r} as {name} is no whole number from 1"
    suite, function, optimizer, budget = (texts.get(name, "") for name in ("suite", "function", "optimizer", "budget"))
    return PaperCell(int(line), suite, function, optimizer, **wholes, budget=budget, numbers=numbers, reasons=reasons)
