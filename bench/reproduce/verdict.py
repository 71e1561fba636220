"""Judge the cells of a published table: our trials against its mean, SD, median, best, worst and number of runs.

Errors of optimizers are skewed, with zeros and ties, and few runs are printed as two numbers. Three things keep false
claims of a difference rare without an assumption on the distribution (``validation/reproduce.py`` has the rates):

- the means are compared by Student's t with the larger of the two SDs: with the pooled one, or by Welch's test, the
  sample without an outlier claims too much;
- no test of n and m runs has a p below that of two samples that do not overlap, 2 / C(n + m, n);
- all else is counted: how many of our trials lie on one side of a best, median or worst, or of all that the printed
  SD allows (Samuelson's inequality), and how many of theirs can lie on one side of our quartiles, by Markov's and
  Cantelli's inequalities. Whatever the distribution, these counts
  have one exact law, the negative hypergeometric (precedence tests; Balakrishnan and Ng 2006).

The p of a cell is Bonferroni's over its tests, that of a table Holm's over its cells. A cell that does not differ is
*alike* where the 90% interval of the difference of means, by t, also lies within one SD (the printed one, or ours where
none is), and within what the printed mean lies above the lowest value (Schuirmann 1987); else it is *open*. This is no
claim that the means of all runs are near: with errors so skewed that few runs fail by far, neither sample need have
such a run. The sentence on a table says how rare a failure may be that a sample does not show.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import stats

from bench.analysis import ALPHA, holm
from bench.contract.typing import Floats
from bench.helpers.parsing import JsonObject
from bench.helpers.text import count, listed
from bench.reproduce.criticism import contradiction
from bench.reproduce.table import NEAR, PaperCell, PaperTable, Printed

ALIKE, DIFFERS, OPEN, UNJUDGED = "alike", "differs", "open", "not judged"
HEADS = ("cell", "printed", "ours", "shift", "p", "verdict")
NOTE = "shift: our mean less theirs, in their SDs (ours where none is printed); p: adjusted over the table"
SHOWN = 6
"""Functions that the sentence on a table names."""


class CellOutcome(NamedTuple):
    """The outcome of a cell's tests: the joint p, whether the means seem near, and the number that differs."""

    p: Floats
    near: NDArray[np.bool_]
    by: NDArray[np.str_]


@dataclass(frozen=True)
class Judgement:
    """The verdict on a cell.

    Attributes:
        cell: as printed.
        values: (n,) our final values, empty where there are none.
        p: of its tests, adjusted over them; 1 where none could be made.
        near: whether the interval of their difference lies within one SD and the printed mean.
        by: the printed number whose test has the least p.
        reason: why it is not judged, "" where it is.
        verdict: one of alike, differs, open and not judged.
    """

    cell: PaperCell
    values: Floats
    p: float = 1.0
    near: bool = False
    by: str = ""
    reason: str = ""
    p_table: float = 1.0
    verdict: str = UNJUDGED

    @property
    def shift(self) -> float:
        """Our mean less the printed one, in printed SDs (ours where none is printed); NaN where it is unknown."""
        numbers = self.cell.numbers
        if "mean" not in numbers or not len(self.values):
            return math.nan
        gap = float(self.values.mean()) - numbers["mean"].value
        sd = numbers["sd"].value if "sd" in numbers else float(self.values.std(ddof=1))
        return gap / sd if sd else math.copysign(math.inf, gap) if gap else 0.0


def judge(table: PaperTable, samples: Mapping[PaperCell, Floats], reasons: Mapping[PaperCell, str]) -> list[Judgement]:
    """Return the verdicts on all cells of a table, in its order.

    Args:
        table: what is printed.
        samples: our final values by cell, at least two each.
        reasons: why other cells have none.
    """
    zero = float(table.settings.get("zero", 0.0)) if table.errors else 0.0
    found = []
    for cell in table.cells:
        if cell in samples:
            each = _judged(cell, samples[cell], table.lowest, zero)
            if not each.reason and (contradicted := contradiction(table, cell)):
                each = Judgement(cell, samples[cell], reason=f"it contradicts itself: {contradicted}")
            found.append(each)
        else:
            found.append(Judgement(cell, np.empty(0), reason=reasons.get(cell, "there are no trials of it")))
    judged = [place for place, each in enumerate(found) if not each.reason]
    adjusted = holm(np.array([found[place].p for place in judged])) if judged else ()
    for place, p in zip(judged, adjusted, strict=True):
        each = found[place]
        verdict = DIFFERS if p <= ALPHA else ALIKE if each.near else OPEN
        found[place] = replace(each, p_table=float(p), verdict=verdict)
    return found


def _judged(cell: PaperCell, values: Floats, lowest: float, zero: float) -> Judgement:
    if cell.runs is None or cell.runs < 2:
        reason = "one run has no spread" if cell.runs else "the number of runs is not printed"
        return Judgement(cell, values, reason=reason)
    numbers = {
        name: Printed(0.0, zero, printed.text) if abs(printed.value) < zero and name != "sd" else printed
        for name, printed in cell.numbers.items()
    }
    if not numbers.keys() & {"mean", "best", "median", "worst"}:
        return Judgement(cell, values, reason="no mean is printed, and no best, median or worst")
    found = compare(numbers, cell.runs, values, lowest)
    return Judgement(cell, values, float(found.p), bool(found.near), str(found.by))


def compare(numbers: Mapping[str, Printed], runs: int, values: Floats, lowest: float = -math.inf) -> CellOutcome:
    """Return the outcome of a cell's tests; without an SD they can only show that our mean is larger.

    Args:
        numbers: printed numbers by statistic, a mean, best, median or worst among them.
        runs: behind them, at least two.
        values: (..., n) ours, at least two.
        lowest: no value is below, -inf where nothing is known; a printed best replaces it.
    """
    tests: dict[str, Floats] = {}
    near = np.zeros(values.shape[:-1], dtype=bool)
    if "mean" in numbers:
        mean, sd = numbers["mean"], numbers.get("sd")
        least = numbers["best"].low if "best" in numbers else lowest
        p, near = compare_means(mean, sd, runs, least, values)
        tests |= {} if sd is None else {"mean": p}
        tests["mean and SD" if sd else "mean"] = compare_counts(mean, sd, runs, least, values)
        if sd and not {"best", "worst"} <= numbers.keys():  # which bound the range more closely
            tests["spread"] = compare_range(mean, sd, runs, values)
    for name, low, high in (("best", 1, 1), ("median", (runs + 1) // 2, runs // 2 + 1), ("worst", runs, runs)):
        if name in numbers:
            tests[name] = compare_order(numbers[name], runs, low, high, values)
    least = 2 / math.comb(runs + values.shape[-1], runs)  # the smallest p that so many values can have
    all_p = np.maximum(np.array(list(tests.values())), least)
    by = np.array(list(tests))[np.argmin(all_p, axis=0)]
    return CellOutcome(np.minimum(1.0, len(tests) * all_p.min(axis=0)), near, by)


def compare_means(
    mean: Printed, sd: Printed | None, runs: int, lowest: Floats | float, values: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the two-sided p of equal means, and whether they seem near (see the module).

    Args:
        mean: as printed; the difference counts from its last digit on.
        sd: as printed; None takes ours for both, which skewed errors make wrong: the p is worth nothing then.
        runs: behind the printed mean, at least two.
        lowest: no value is below; ``-inf`` where nothing is known.
        values: (..., n) ours, at least two.
    """
    trials = values.shape[-1]
    ours, our_sd = values.mean(axis=-1), values.std(axis=-1, ddof=1)
    gap = np.maximum(np.abs(ours - mean.value) - mean.unit - NEAR * np.abs(mean.value), 0.0)
    printed = our_sd if sd is None else sd.value + sd.unit
    spread = np.maximum(printed, our_sd)
    with np.errstate(divide="ignore", invalid="ignore"):
        p = stats.ttest_ind_from_stats(gap, spread, runs, 0.0, spread, trials).pvalue
    p = np.where(gap == 0, 1.0, np.where(spread == 0, 0.0, p))
    half = stats.t.ppf(1 - ALPHA, runs + trials - 2) * spread * math.sqrt(1 / runs + 1 / trials)
    margin = np.minimum(printed, mean.high - lowest) + NEAR * np.abs(mean.value)
    return p, gap + half <= margin


def compare_order(printed: Printed, runs: int, low: int, high: int, values: Floats) -> Floats:
    """Return the two-sided p that our values and a printed order statistic are of one distribution, whatever it is.

    Ties and the rounding of the printed number make it larger, never smaller.

    Args:
        printed: the order statistic of ``runs`` runs, or a number between two: from the ``low``-th on, up to the
            ``high``-th, counted from 1.
        runs: behind it.
        low: see there.
        high: see there.
        values: (..., n) ours.
    """
    n = values.shape[-1]
    low_end, high_end = (np.asarray(end)[..., np.newaxis] for end in (printed.low, printed.high))
    below, above = (values < low_end).sum(axis=-1), (values > high_end).sum(axis=-1)
    # Of both samples in order, our values before the high-th of theirs, and from the other end.
    p = np.minimum(_before(n, runs, high)[below], _before(n, runs, runs + 1 - low)[above])
    return np.asarray(np.minimum(1.0, 2 * p))


def compare_counts(mean: Printed, sd: Printed | None, runs: int, lowest: Floats | float, values: Floats) -> Floats:
    """Return the two-sided p that our values and those behind a mean are of one distribution, whatever it is.

    At least so many of their values lie below our lower quartile (Markov, Cantelli), and above our upper one
    (Cantelli), and how many there are has an exact law.

    Args:
        mean: as printed.
        sd: as printed, None where it is not.
        runs: behind them.
        lowest: no value is below; ``-inf`` where nothing is known.
        values: (..., n) ours.
    """
    n = values.shape[-1]
    ordered, place = np.sort(values, axis=-1), n // 4
    low, high = ordered[..., place], ordered[..., n - 1 - place]
    with np.errstate(divide="ignore", invalid="ignore"):
        markov = np.where((low > lowest) & (lowest > -math.inf), (mean.high - lowest) / (low - lowest), 1.0)
        above = np.minimum(markov, _share(low - mean.high, sd))
        below = _share(mean.low - high, sd)
    p = [
        _before(runs, n, place + 1)[np.ceil(runs * (1 - np.minimum(share, 1.0)) - 1e-9).astype(int)]
        for share in (above, below)
    ]
    return np.asarray(np.minimum(1.0, 2 * np.minimum(*p)))


def compare_range(mean: Printed, sd: Printed, runs: int, values: Floats) -> Floats:
    """Return the two-sided p that our values beyond the range of theirs are of one distribution, whatever it is.

    No value of n is farther than SD √(n - 1) from their mean where the SD has n in it, and (n - 1) / √n where it has
    n - 1 (Samuelson 1968, J. Am. Stat. Assoc. 63); the first is the larger, and paper and code may have either.

    Args:
        mean: as printed.
        sd: as printed.
        runs: behind them, at least two.
        values: (..., n) ours.
    """
    reach = sd.high * math.sqrt(runs - 1)
    low, high = (np.asarray(end)[..., np.newaxis] for end in (mean.low - reach, mean.high + reach))
    beyond = np.maximum((values < low).sum(axis=-1), (values > high).sum(axis=-1))
    return np.asarray(np.minimum(1.0, 2 * _before(values.shape[-1], runs, 1)[beyond]))


def _share(distance: Floats, sd: Printed | None) -> Floats:
    """Return the largest share of values farther than a distance beyond their mean (Cantelli's inequality)."""
    if sd is None:
        return np.ones_like(distance)
    variance = (sd.value + sd.unit) ** 2
    return np.where(distance > 0, variance / (variance + np.maximum(distance, 0.0) ** 2), 1.0)


@cache
def _before(ours: int, theirs: int, place: int) -> Floats:
    """Return (ours + 1,) the chances that at least 0, 1, … of ours come before the ``place``-th of theirs in order."""
    return np.asarray(stats.nhypergeom.sf(np.arange(-1, ours), ours + theirs, ours, place), dtype=np.float64)


def frame(judgements: Sequence[Judgement]) -> pd.DataFrame:
    """Return the verdicts as a table, a row for each cell."""
    rows: list[JsonObject] = []
    for each in judgements:
        cell, ours = each.cell, each.values
        printed = {name: cell.numbers[name].value for name in cell.numbers if name not in ("rank", "success")}
        own = {"mean": ours.mean(), "sd": ours.std(ddof=1), "best": ours.min(), "median": np.median(ours),
               "worst": ours.max()} if len(ours) else {}  # fmt: skip
        rows.append(
            {"line": cell.line, "suite": cell.suite, "function": cell.function, "dimension": cell.dimension,
             "optimizer": cell.optimizer, "runs": cell.runs, **{f"printed_{k}": v for k, v in printed.items()},
             "trials": len(ours), **{f"our_{k}": float(v) for k, v in own.items()}, "shift_in_sd": each.shift,
             "p": each.p, "by": each.by, "p_holm": each.p_table, "verdict": each.verdict, "reason": each.reason}
        )  # fmt: skip
    return pd.DataFrame(rows)


def shown(judgements: Sequence[Judgement]) -> list[tuple[str, ...]]:
    """Return a row of :data:`HEADS` for each cell that is judged."""
    rows: list[tuple[str, ...]] = []
    for each in judgements:
        if each.verdict != UNJUDGED:
            numbers, ours = each.cell.numbers, each.values
            printed = " ± ".join(numbers[name].text for name in ("mean", "sd") if name in numbers and "mean" in numbers)
            own = f"{ours.mean():.4g} ± {ours.std(ddof=1):.2g}"
            where = each.cell.where.rpartition(" (line")[0]
            rows.append(
                (
                    where,
                    printed or "no mean",
                    own,
                    "" if math.isnan(each.shift) else _few(each.shift, "+"),
                    f"{each.p_table:.2g}",
                    each.verdict,
                )
            )
    return rows


def unjudged(judgements: Sequence[Judgement]) -> list[str]:
    """Return a sentence for each reason why cells are not judged."""
    reasons: dict[str, list[str]] = {}
    for each in judgements:
        if each.reason:
            reasons.setdefault(each.reason, []).append(each.cell.where)
    more = {
        reason: f" and {count(len(cells) - 1, 'more cell')}" * (len(cells) > 1) for reason, cells in reasons.items()
    }
    return [f"not judged: {cells[0]}{more[reason]}: {reason}" for reason, cells in reasons.items()]


def sentences(judgements: Sequence[Judgement]) -> list[str]:
    """Return the verdict on a table: the cells that differ, those that do not, and what so few runs cannot show."""
    groups = {kind: [each for each in judgements if each.verdict == kind] for kind in (ALIKE, DIFFERS, OPEN, UNJUDGED)}
    judged = len(judgements) - len(groups[UNJUDGED])
    if not judged:
        return [f"none of {count(len(judgements), 'cell')} can be judged"]
    number = len(groups[DIFFERS])
    differ = f"{number} of {count(judged, 'cell')} differ{'s' * (number == 1)}, tested at {ALPHA:.0%} over the table"
    said = [f"{differ}: {_named(groups[DIFFERS])}" if number else differ]
    if groups[ALIKE]:
        own = " (ours, where none is printed)" if any("sd" not in each.cell.numbers for each in groups[ALIKE]) else ""
        fewest = min(len(each.values) for each in groups[ALIKE])
        said.append(
            f"{len(groups[ALIKE])} do not differ, and the 90% interval (t) of the difference of their means lies "
            f"within one SD{own}; a failure rate of up to {unseen(fewest):.0%} can go unseen in {count(fewest, 'run')}"
        )
    if groups[OPEN]:
        number = len(groups[OPEN])
        wider = "the interval is" if number == 1 else "their intervals are"
        said.append(f"{number} {'is' if number == 1 else 'are'} open: no test shows a difference, and {wider} wider")
    return said


def unseen(runs: int) -> float:
    """Return the share of failures that no run of a sample shows with a probability of 5%."""
    return float(1 - ALPHA ** (1 / runs))


def _named(judgements: Sequence[Judgement]) -> str:
    """Return the functions and how far their cells differ, those with most first."""
    groups: dict[str, list[Judgement]] = {}
    for each in judgements:
        groups.setdefault(each.cell.where.rpartition(", ")[0], []).append(each)
    order = sorted(groups, key=lambda name: -len(groups[name]))
    names = [f"{name} ({listed([_far(each) for each in groups[name]])})" for name in order[:SHOWN]]
    rest = len(order) - SHOWN
    return "; ".join(names) + (f"; and {count(rest, 'function')} more" if rest > 0 else "")


def _few(shift: float, sign: str = "") -> str:
    """Return a shift in SDs as text; above a hundred its size says how small the SD is and nothing of the means."""
    return f"{shift:{sign}.2g}" if abs(shift) <= 100 else "over 100" if shift > 0 else "under -100"


def _far(each: Judgement) -> str:
    shift = each.shift
    if not each.by.startswith("mean"):
        return f"{each.cell.optimizer} by its {each.by}"
    size = "" if math.isinf(shift) or "sd" not in each.cell.numbers else f"{_few(abs(shift))} SD "
    return f"{each.cell.optimizer} {size}{'higher' if shift > 0 else 'lower'}"
