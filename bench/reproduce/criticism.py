"""Read a published table critically: which of its cells contradict themselves, each other, or the problem.

Every check holds for any sample of n values, whatever its distribution, and allows for a unit of the last digit of all
printed numbers: what it finds, no n runs can have given. A cell without what a check needs passes it. Sources: GRIM
(Brown and Heathers 2017, Soc. Psychol. Personal. Sci. 8) for means of counts; the largest SD of values within limits is
that of Bhatia and Davis (2000, Am. Math. Mon. 107), and a mean is within one SD of the median (Hotelling and Solomons
1932, Ann. Math. Stat. 3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import permutations
from typing import NamedTuple

from bench.helpers.errors import BenchError
from bench.helpers.text import count
from bench.reproduce.names import load_problem
from bench.reproduce.table import PaperCell, PaperTable, Printed


class Remark(NamedTuple):
    """A contradiction: the cell in words, the kind of check that found it, and what is wrong in a sentence."""

    where: str
    kind: str
    sentence: str


class CellFacts(NamedTuple):
    """Facts on a cell beside its numbers: the lowest possible value and its source, and whether values are counts."""

    lowest: float
    counts: bool
    source: str = ""
    optimum: bool = False
    """Whether the optimum of its problem is known."""


def facts_of(table: PaperTable, cell: PaperCell) -> tuple[CellFacts, str]:
    """Return the facts on a cell, and why its problem cannot be loaded and adds none, "" where it can."""
    counts = table.settings.get("counts") is True
    try:
        problem = load_problem(table, cell)
        optimum = problem.optimum
    except BenchError as error:
        return CellFacts(table.lowest, counts), str(error)
    lowest = table.lowest if table.errors or optimum is None else max(optimum, table.lowest)
    return CellFacts(lowest, counts, problem.optimum_source, optimum is not None), ""


def contradiction(table: PaperTable, cell: PaperCell) -> str:
    """Return the first way in which the numbers of a cell exclude each other, "" where they do not."""
    facts, _ = facts_of(table, cell)
    found = (text for kind, check in CHECKS.items() if kind != "below the optimum" for text in check(cell, facts))
    return next(found, "")


def criticise(table: PaperTable) -> tuple[list[Remark], list[str]]:
    """Return the contradictions of a table, and sentences on what could not be checked."""
    remarks, notes, below = [], [], 0
    unknown: dict[str, str] = {}
    known = 0
    for cell in table.cells:
        facts, error = facts_of(table, cell)
        known += facts.optimum
        if error:
            unknown.setdefault(error, cell.where)
        found = [Remark(cell.where, kind, text) for kind, check in CHECKS.items() for text in check(cell, facts)]
        below += any(remark.kind == "below the optimum" for remark in found)
        remarks += found
    notes += [f"the optimum of {where} is not known here: {error}" for error, where in unknown.items()]
    if below > known / 2 and not table.settings.get("values"):
        notes.append(
            f"{below} of {count(known, 'cell')} are below the optimum: if the table prints errors, say so by "
            "'# values = \"error\"' at its top"
        )
    return [*remarks, *_ranks(table.cells), *_averages(table)], notes


def _below(cell: PaperCell, facts: CellFacts) -> Iterator[str]:
    limit = facts.lowest - 1e-9 * max(1.0, abs(facts.lowest))
    for name in ("best", "median", "mean", "worst"):
        if name in cell.numbers and cell.numbers[name].high < limit:
            known = f" ({facts.source})" if facts.source else ""
            what = f"the optimum, {facts.lowest:.10g}{known}" if facts.lowest else "the lowest possible value, 0"
            yield f"its {name} {cell.numbers[name].text} is below {what}"
            return


def _order(cell: PaperCell, _: CellFacts) -> Iterator[str]:
    numbers = cell.numbers
    for low, high in (("best", "mean"), ("best", "median"), ("mean", "worst"), ("median", "worst"), ("best", "worst")):
        if low in numbers and high in numbers and numbers[low].low > numbers[high].high:
            yield f"its {low} {numbers[low].text} is above its {high} {numbers[high].text}"


def _sd(cell: PaperCell, facts: CellFacts) -> Iterator[str]:
    """Compare the SD, with n or n - 1 in it, with what mean, median, best, worst and the lowest value allow."""
    numbers, n = cell.numbers, cell.runs
    if "sd" not in numbers:
        return
    sd = numbers["sd"]
    if sd.high < 0:
        yield f"its SD {sd.text} is negative"
        return
    if "mean" not in numbers or n is None:
        return
    mean, said = numbers["mean"], f"an SD of {sd.text} with the mean {numbers['mean'].text}"
    if n == 1:
        if sd.low > 0:
            yield f"one run has no SD, and {sd.text} is printed"
        return
    least = numbers["best"].low if "best" in numbers else facts.lowest
    floor = f"the best {numbers['best'].text}" if "best" in numbers else f"no value below {facts.lowest:.10g}"
    above = mean.high - least
    if not 0 <= above < math.inf:  # an order of its own, or no limit
        pass
    elif sd.low > math.sqrt(n) * above:
        yield f"{said} and {floor} needs more than {n} runs: at most {math.sqrt(n) * above:.4g} is possible"
    elif "worst" in numbers:
        most = math.sqrt(n / (n - 1) * above * max(numbers["worst"].high - mean.low, 0.0))
        if sd.low > most:
            yield f"{said}, {floor} and the worst {numbers['worst'].text} is impossible: at most {most:.4g}"
    for name in ("best", "worst"):
        if name in numbers:
            far = max(mean.low - numbers[name].high, numbers[name].low - mean.high)
            if far / math.sqrt(n - 1) > sd.high:
                yield f"{said} and the {name} {numbers[name].text} is impossible: at least {far / math.sqrt(n - 1):.4g}"
    if "median" in numbers:
        far = max(mean.low - numbers["median"].high, numbers["median"].low - mean.high)
        if far > sd.high:
            yield f"{said} and the median {numbers['median'].text} is impossible: they differ by more than one SD"


def _middle(cell: PaperCell, _: CellFacts) -> Iterator[str]:
    """Compare the mean with what the median leaves open: half of the runs are on either side of it."""
    numbers, n = cell.numbers, cell.runs
    if n is None or not {"mean", "median"} <= numbers.keys():
        return
    outer, median, mean = (n - 1) // 2, numbers["median"], numbers["mean"]
    if "best" in numbers and mean.high < (outer * numbers["best"].low + (n - outer) * median.low) / n:
        yield f"its mean {mean.text} is too low for the best {numbers['best'].text} and the median {median.text}"
    if "worst" in numbers and mean.low > (outer * numbers["worst"].high + (n - outer) * median.high) / n:
        yield f"its mean {mean.text} is too high for the median {median.text} and the worst {numbers['worst'].text}"


def _wholes(number: Printed, parts: int) -> range:
    """Return the whole numbers that, divided by ``parts``, are printed so."""
    return range(math.ceil(number.low * parts), math.floor(number.high * parts) + 1)


def _digits(cell: PaperCell, facts: CellFacts) -> Iterator[str]:
    """Test whether n counts can have the mean (GRIM), and n runs the rate of success."""
    numbers, n = cell.numbers, cell.runs
    if n is None:
        return
    if "success" in numbers:
        rate = numbers["success"]
        percent = rate._replace(value=rate.value / 100, unit=rate.unit / 100)
        as_shares = [part for part in (rate, percent) if part.low <= 1 and any(0 <= k <= n for k in _wholes(part, n))]
        if not as_shares and not any(0 <= k <= n for k in _wholes(rate, 1)):
            yield f"its rate of success {rate.text} is no part of {count(n, 'run')}"
    if not facts.counts or "mean" not in numbers:
        return
    mean = numbers["mean"]
    if not _wholes(mean, n):
        yield f"its mean {mean.text} is none of {n} whole numbers"


CHECKS: dict[str, Callable[[PaperCell, CellFacts], Iterator[str]]] = {
    "below the optimum": _below,
    "order": _order,
    "impossible SD": _sd,
    "impossible mean": _middle,
    "digits": _digits,
}
"""The checks of one cell, by kind."""


def _ranks(cells: Sequence[PaperCell]) -> Iterator[Remark]:
    """Yield a remark on each cell whose rank contradicts the numbers that the ranks of its table follow best."""
    ranked = [cell for cell in cells if "rank" in cell.numbers]
    groups: dict[tuple[object, ...], list[PaperCell]] = {}
    for cell in ranked:
        groups.setdefault(cell.key[:-1], []).append(cell)
    names = [name for name in ("mean", "best", "median") if all(name in cell.numbers for cell in ranked)]
    wrong = {name: [pair for group in groups.values() if (pair := _swapped(group, name))] for name in names}
    if not names:
        return
    followed = min(wrong, key=lambda name: len(wrong[name]))
    if followed != "mean" and "mean" in names:
        first, other = wrong["mean"][0]
        yield Remark(
            first.where, "rank",
            f"the ranks are those of {followed}, not of mean: rank {first.numbers['rank'].text} has the mean "
            f"{first.numbers['mean'].text}, rank {other.numbers['rank'].text} the lower {other.numbers['mean'].text}",
        )  # fmt: skip
    for first, other in wrong[followed]:
        yield Remark(
            first.where, "rank",
            f"its rank {first.numbers['rank'].text} with the {followed} {first.numbers[followed].text} is before rank "
            f"{other.numbers['rank'].text} of {other.optimizer} with the lower {other.numbers[followed].text}",
        )  # fmt: skip


def _swapped(group: Sequence[PaperCell], name: str) -> tuple[PaperCell, PaperCell] | None:
    """Return two cells of a function of which the first has the better rank and surely the higher number."""
    pairs = (
        (first, other)
        for first, other in permutations(group, 2)
        if first.numbers["rank"].value < other.numbers["rank"].value
        and first.numbers[name].low > other.numbers[name].high
    )
    return next(pairs, None)


def _averages(table: PaperTable) -> Iterator[Remark]:
    """Yield a remark on each average over functions that is not the average of the cells above it."""
    for average in table.averages:
        cells = [
            cell
            for cell in table.cells
            if cell.optimizer == average.optimizer and average.dimension in (None, cell.dimension)
        ]
        for name, printed in average.numbers.items():
            # A row "average rank" of a table of means has its number in the column of means.
            of = (
                "rank" if "rank" in average.function.lower() and all("rank" in cell.numbers for cell in cells) else name
            )
            parts = [cell.numbers[of] for cell in cells if of in cell.numbers]
            if not parts or len(parts) < len(cells):
                continue
            slack = 0.0 if of == "rank" else math.fsum(part.unit for part in parts) / len(parts)
            mean = math.fsum(part.value for part in parts) / len(parts)
            if not printed.low - slack <= mean <= printed.high + slack:
                yield Remark(
                    average.where, "average",
                    f"its {of} {printed.text} is not the average of {count(len(parts), 'cell')}, {mean:.6g}",
                )  # fmt: skip
