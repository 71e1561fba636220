"""Write numbers, lists and counts for sentences and table cells."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from bench.contract.typing import Options
from bench.helpers.text import count as count
from bench.helpers.text import listing as listing
from bench.helpers.text import option

MISSING = "–"
MOST_LEADERS = 8  # optimizers that a sentence names


def cell_text(value: Any, decimals: int | None = None) -> str:
    """Return a table's value as text: yes or no, – where missing, ∞, fixed decimals or four significant digits."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if pd.isna(value):
        return MISSING
    if isinstance(value, (float, np.floating)):
        if math.isinf(value):
            return "∞" if value > 0 else "−∞"
        return f"{value:.4g}" if decimals is None else f"{value:,.{decimals}f}"
    if isinstance(value, (int, np.integer)):
        return f"{value:,}"
    return str(value)


def usual_decimals(values: object) -> int | None:
    """Return the decimals for four significant digits of a column's values, None where their sizes differ too much."""
    sizes = np.abs(np.asarray(values, dtype=float))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    if not len(sizes) or not 1e-3 < sizes.max() < 1e5 or sizes.max() > 1e3 * sizes.min():
        return None
    return max(3 - math.floor(math.log10(sizes.max())), 0)


def row_texts(values: Iterable[float]) -> list[str]:
    """Return numbers that are compared with each other as texts of four significant digits, or up to six.

    The fewest digits that make the most texts different: numbers of one text are not distinguished by six digits.
    """
    numbers = list(values)
    texts = [[_significant(number, digits) for number in numbers] for digits in (4, 5, 6)]
    return max(texts, key=lambda texts_of_digits: len(set(texts_of_digits)))


def _significant(value: float, digits: int) -> str:
    """Return a number with at least these significant digits; 0 and no number as :func:`cell_text` writes them."""
    if value == 0 or not math.isfinite(value):
        return cell_text(value)
    if not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}"
    return f"{value:,.{max(digits - 1 - math.floor(math.log10(abs(value))), 0)}f}"


def percent(share: float) -> str:
    """Return a share in percent, which is 0% or 100% for none and all alone."""
    return "<1%" if 0 < share < 0.005 else ">99%" if 0.995 <= share < 1 else f"{share:.0%}"


def p_text(p: float) -> str:
    """Return a p-value as papers print it: ``"p = 0.013"``, or ``"p < 0.001"``."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}"


def leaders(marks: pd.DataFrame, feature: str) -> str:
    """Return names with their counts: ``"a had the lowest median on 3 of 4 problems and b on 1"``.

    Args:
        marks: problems by optimizers, true where the optimizer has the feature; a row without any mark is left out.
        feature: such as ``"the lowest median"``.
    """
    totals = marks.sum().sort_values(ascending=False, kind="stable")
    totals = totals[totals > 0]
    if totals.empty:
        return f"{feature} is not known"
    marked = marks[marks.any(axis=1)]
    first = f"{totals.index[0]} had {feature} on {totals.iloc[0]} of {count(len(marked), 'problem')}"
    parts = [first, *(f"{label} on {number}" for label, number in totals.iloc[1:].items())]
    if len(parts) > MOST_LEADERS:
        last = totals.iloc[MOST_LEADERS - 1 :]
        parts[MOST_LEADERS - 1 :] = [f"{len(last)} others on at most {last.iloc[0]} each"]
    ties = " (a tie counts for each)" if (marked.sum(axis=1) > 1).any() else ""
    return f"{listing(parts)}{ties}"


def options(values: Options) -> str:
    """Return options of a plug-in as ``"agents = 300, handling = repair"``."""
    return ", ".join(f"{key} = {option(value)}" for key, value in values.items())


def interval(low: float, high: float, decimals: int | None) -> str:
    """Return an interval as ``"2.48 to 2.60"``, – where it is missing."""
    return MISSING if pd.isna(low) else f"{cell_text(low, decimals)} to {cell_text(high, decimals)}"


def unfinished_trials(frame: pd.DataFrame) -> str:
    """Return a sentence on how many trials of which optimizers failed or timed out; "" where all finished."""
    unfinished = frame[frame["status"] != "ok"]
    if unfinished.empty:
        return ""
    by_optimizer = unfinished["optimizer"].astype(str).value_counts(sort=False)
    late = int((unfinished["status"] == "timeout").sum())
    kinds = [
        f"{number:,} {kind}" for kind, number in (("failed", len(unfinished) - late), ("timed out", late)) if number
    ]
    owners = listing([f"{number:,} of {label}" for label, number in by_optimizer.items()])
    return f"{len(unfinished):,} of {count(len(frame), 'trial')} did not finish ({listing(kinds)}): {owners}."


def seconds(value: float) -> str:
    """Return a duration with its unit, such as ``"12 ms"`` or ``"3.4 s"``."""
    return f"{1000 * value:.3g} ms" if value < 1 else f"{value:.3g} s"
