"""Numbers and lists in words."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

MISSING = "–"


def cell_text(value: Any, decimals: int | None = None) -> str:
    """Return a table's value as shown: yes or no, – where missing, ∞, fixed decimals or four significant digits."""
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


def usual_decimals(values: Any) -> int | None:
    """Return the decimals that show a column's values with four significant digits, None where they span too much."""
    sizes = np.abs(np.asarray(values, dtype=float))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    if not len(sizes) or not 1e-3 < sizes.max() < 1e5 or sizes.max() > 1e3 * sizes.min():
        return None
    return max(3 - math.floor(math.log10(sizes.max())), 0)


def count(number: int, noun: str, plural: str = "") -> str:
    """Return ``"1 trial"``, ``"2 trials"`` or ``"60,000 trials"``; a plural that is not in -s is given."""
    return f"{number:,} {noun if number == 1 else plural or noun + 's'}"


def p_text(p: float) -> str:
    """Return a p-value as papers print it: ``"p = 0.013"``, or ``"p < 0.001"``."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}"


def shares(marks: pd.DataFrame) -> str:
    """Return in words how often each column is marked, of the rows with any mark; ties count for each."""
    totals = marks.sum().sort_values(ascending=False, kind="stable")
    parts = [f"{label}’s on {number}" for label, number in totals.items() if number]
    return f"{listing(parts)} of {count(int(marks.any(axis=1).sum()), 'problem')}" if parts else "not known"


def listing(items: Sequence[str], at_most: int = 8) -> str:
    """Return ``"a, b and c"``, shortened to ``"a, b and 5 more"`` beyond ``at_most``."""
    shown = list(items)
    if len(shown) > at_most:
        shown = [*shown[: at_most - 1], f"{len(shown) - at_most + 1} more"]
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} and {shown[-1]}"


def options(given: Mapping[str, Any]) -> str:
    """Return options as ``"agents = 300, handling = repair"``."""
    pairs = given.items()
    return ", ".join(
        f"{key} = {value if isinstance(value, str) else json.dumps(value, default=str)}" for key, value in pairs
    )


def interval(low: float, high: float, decimals: int | None) -> str:
    """Return an interval as ``"2.48 to 2.60"``, – where it is not known."""
    return MISSING if pd.isna(low) else f"{cell_text(low, decimals)} to {cell_text(high, decimals)}"


def losses(frame: pd.DataFrame) -> str:
    """Return in a sentence how many trials failed or ran out of time, and whose they are; "" for none."""
    lost = frame[frame["status"] != "ok"]
    if lost.empty:
        return ""
    owners = lost["optimizer"].astype(str).value_counts(sort=False)
    late = int((lost["status"] == "timeout").sum())
    kinds = [f"{number:,} {kind}" for kind, number in (("failed", len(lost) - late), ("timed out", late)) if number]
    whose = listing([f"{number:,} of {label}" for label, number in owners.items()])
    return f"{len(lost):,} of {count(len(frame), 'trial')} did not finish ({listing(kinds)}): {whose}."


def seconds(value: float) -> str:
    """Return a duration with its unit, such as ``"12 ms"`` or ``"3.4 s"``."""
    return f"{1000 * value:.3g} ms" if value < 1 else f"{value:.3g} s"
