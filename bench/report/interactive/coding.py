"""Write numbers in few characters, for data inside a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from bench.typing import Floats

STEPS = 1000  # of a decade: a value is rounded to 0.12% at most
NEVER, REACHED = "i", "z"
LEVELS = 9999  # of a signal between its lowest and its highest value


def coded(distances: Floats) -> list[str]:
    """Return each row of (n, m) distances from the best value, 0 to +inf and never rising, as a text.

    A row's levels are round(1000 log10(distance)), the first as it is and each other one as its decrease, separated by
    commas: an empty text where nothing changes, "z" where the distance becomes 0, "i" while it is infinite. What stays
    the same to the end is left out.
    """
    with np.errstate(divide="ignore"):
        levels = np.rint(STEPS * np.log10(distances))
    return [_row(levels_of_row) for levels_of_row in levels.tolist()]


def _row(levels: Sequence[float]) -> str:
    texts, before = [], np.nan
    for level in levels:
        if level == before:
            texts.append("")
        elif np.isinf(level):
            texts.append(NEVER if level > 0 else REACHED)
        else:
            texts.append(f"{before - level if np.isfinite(before) else level:.0f}")
        before = level
    return ",".join(texts).rstrip(",")


def signal(values: ArrayLike) -> dict[str, Any]:
    """Return a signal (N,) as its lowest and highest value and the steps between neighbours, of which 9999 lie between.

    ``{"low": …, "high": …, "steps": "4211,12,-3,,…"}``: the first number is a level, an empty text no step.
    """
    samples = np.asarray(values, dtype=np.float64)
    low, high = float(samples.min()), float(samples.max())
    levels = np.rint(LEVELS * (samples - low) / (high - low)) if high > low else np.zeros(len(samples))
    steps = np.diff(levels, prepend=0.0).astype(int).tolist()
    return {
        "low": short(low, 7),
        "high": short(high, 7),
        "steps": ",".join(str(step) if step else "" for step in steps),
    }


def short(value: Any, digits: int = 7) -> float | int | None:
    """Return a number rounded to some significant digits; None where it is missing or not finite."""
    number = float("nan") if pd.isna(value) else float(value)
    if not np.isfinite(number):
        return None
    rounded = float(f"{number:.{digits}g}")
    return int(rounded) if rounded.is_integer() and abs(rounded) < 2**53 else rounded


def packed(values: Sequence[Any]) -> Any:
    """Return the values as a list, or the one value that all of several have in common."""
    first = values[0] if len(values) else None
    return first if len(values) > 1 and all(value == first for value in values) else list(values)
