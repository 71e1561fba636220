"""The region of practical equivalence (rope) of a study: differences that are too small to matter."""

from __future__ import annotations

import math
from typing import Any

from bench.errors import BenchError

Rope = float | str
"""As a study holds it: a width in the unit of the objective, or a share of the values such as ``"1%"``."""


def checked(value: Any, what: str) -> Rope:
    """Return a rope as a study holds it: a positive number, or a percentage below 100.

    Args:
        value: a number, a percentage such as ``"1%"``, or a text of either.
        what: the subject of a sentence about it, such as ``"the rope"``.

    Raises:
        BenchError: for anything else.
    """
    if isinstance(value, str):
        text, percent = value.strip().removesuffix("%").strip(), value.strip().endswith("%")
    else:
        text, percent = str(value), False
    try:
        number = math.nan if isinstance(value, bool) else float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < (100 if percent else math.inf):
        raise BenchError(
            f"{what} must be a positive width in the unit of the objective, such as 0.5, or a percentage of the values "
            f"below 100, such as '1%', not {value!r}"
        )
    return f"{number:.12g}%" if percent else number


def share(rope: Rope) -> float | None:
    """Return the share of a rope that is a percentage, None for an absolute one."""
    return float(rope.removesuffix("%")) / 100 if isinstance(rope, str) else None
