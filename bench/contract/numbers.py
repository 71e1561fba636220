"""Check numbers that users give; raise one sentence for a wrong type or range."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from numbers import Integral, Real
from typing import TypeGuard

from bench.helpers.errors import BenchError

LARGEST_BUDGET = 10**15
"""Evaluations of a trial, in all or a dimension, which no run reaches."""

MOST_TRIALS = 1_000_000
"""Trials of a cell that a study may ask for."""

LARGEST_SEED = 2**63 - 1
"""Seeds of trials are hashes of 63 bits; a store keeps them as whole numbers of SQLite."""

MOST_PARALLEL = 1000
"""Points of a call that may be evaluated at a time, each by a process."""

MOST_JOBS = 1000
"""Trials made at a time on one machine; each has a process and a thread of its own."""


def is_whole(value: object) -> TypeGuard[int]:
    """Return whether the value is a whole number; True and False are not."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def is_finite(value: object) -> TypeGuard[float]:
    """Return whether the value is a finite number; True and False are not."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number that no float can hold
        return False


def require_whole(
    what: str, value: object, minimum: int | None = None, maximum: int | None = None, *, also: str = ""
) -> int:
    """Return a whole number within the closed range; raises BenchError for any other value.

    Args:
        what: the subject of the sentence, such as ``"the seed"``.
        value: what the user gave.
        minimum: the smallest number allowed, None for no limit.
        maximum: the largest number allowed, None for no limit.
        also: what else is allowed, such as ``", or -1 for every core"``.
    """
    low, high = -math.inf if minimum is None else minimum, math.inf if maximum is None else maximum
    if not is_whole(value) or not low <= value <= high:
        raise BenchError(f"{what} must be a whole number{span(minimum, maximum)}{also}, not {value!r}")
    return int(value)


def require_seed(what: str, value: object) -> None:
    """Raise BenchError unless the value is a seed: a whole number from 0 to :data:`LARGEST_SEED`."""
    require_whole(what, value, 0, LARGEST_SEED)


def require_flag(what: str, value: object) -> bool:
    """Return a bool; raises BenchError for any other value."""
    if not isinstance(value, bool):
        raise BenchError(f"{what} must be true or false, not {value!r}")
    return value


def require_jobs(what: str, value: object) -> None:
    """Raise BenchError unless the value is a number of jobs: from 1 to :data:`MOST_JOBS`, or -1 for every core."""
    if value != -1:
        require_whole(what, value, 1, MOST_JOBS, also=", or -1 for every core")


def span(minimum: float | None, maximum: float | None) -> str:
    """Return a closed range as words behind "a number", such as ``" from 1 to 20"``; "" for no limits."""
    if minimum is None:
        return "" if maximum is None else f" of at most {maximum}"
    return f" of at least {minimum}" if maximum is None else f" from {minimum} to {maximum}"


def require_positive(what: str, value: object, maximum: float = math.inf, *, unit: str = "") -> float:
    """Return a finite number above 0 and at most ``maximum`` as a float; raises BenchError for any other value.

    Args:
        what: the subject of the sentence, such as ``"the timeout of a trial"``.
        value: what the user gave.
        maximum: the largest number allowed.
        unit: the unit of the number, such as ``"seconds"``.
    """
    if not is_finite(value) or not 0 < value <= maximum:
        limit = "" if math.isinf(maximum) else f" of at most {maximum:g}"
        units = f" of {unit}" if unit else ""
        raise BenchError(f"{what} must be a positive number{units}{limit}, not {value!r}")
    return float(value)


def seconds(value: object, what: str) -> float:
    """Return a duration in seconds: a positive number of them, or a text such as ``"10 min"`` (s, min, h or d).

    Raises:
        BenchError: for anything else, with ``what`` as the subject of the sentence.
    """
    parts = re.fullmatch(r"\s*([0-9.]+)\s*(s|min|h|d)?\s*", value) if isinstance(value, str) else None
    number = value
    with suppress(ValueError):
        number = float(parts[1]) * _SECONDS[parts[2] or "s"] if parts else value
    if not is_finite(number) or number <= 0:
        raise BenchError(f"{what} must be a number of seconds above 0, or a text such as '10 min', not {value!r}")
    return float(number)


_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
