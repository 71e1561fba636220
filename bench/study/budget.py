"""The budget of a study: a number of evaluations, a multiple of the dimension ("1e4 * d"), or a number by dimension."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from bench.errors import BenchError
from bench.helpers.text import joined
from bench.numbers import LARGEST_BUDGET, is_whole, require_whole

Budget = int | str | dict[str, int]
"""As a study holds it: evaluations, the text of a multiple of d, or evaluations by the dimension as a text."""

_MULTIPLE = re.compile(r"\s*([0-9][0-9_]*(?:\.[0-9]+)?(?:[eE]\+?[0-9]+)?)\s*\*\s*d\s*", re.ASCII)


def checked(value: Any, what: str) -> Budget:
    """Return a budget as a study holds it.

    Args:
        value: a whole number from 1 to 1e15; a text of one, or of a multiple of the dimension such as ``"1e4 * d"``; or
            a table of evaluations by dimension, such as ``{"10": 200_000, "20": 1_000_000}``.
        what: the subject of a sentence about it, such as ``"the budget"``.

    Raises:
        BenchError: for anything else.
    """
    if isinstance(value, Mapping):
        for dimension, number in value.items():
            if not re.fullmatch(r"[1-9][0-9]{0,8}", str(dimension)):
                raise BenchError(f"{what} has a table of evaluations by dimension, but {dimension!r} is no dimension")
            require_whole(f"{what} at d = {dimension}", number, 1, LARGEST_BUDGET)
        if not value:
            raise BenchError(f"{what} is an empty table; give evaluations by dimension, such as {{10 = 200_000}}")
        return {str(dimension): int(number) for dimension, number in value.items()}
    if isinstance(value, str):
        if re.fullmatch(r"[0-9][0-9_]{0,30}", value.strip(), re.ASCII):
            value = int(value)
        elif 0 < _multiple(value) <= LARGEST_BUDGET:
            return value.strip()
    if is_whole(value) and 1 <= value <= LARGEST_BUDGET:
        return int(value)
    raise BenchError(
        f"{what} must be a whole number from 1 to {LARGEST_BUDGET:g} or a multiple of the dimension such as '1e4 * d', "
        f"not {value!r}"
    )


def evaluations(budget: Budget, dimension: int) -> int:
    """Return the evaluations of a trial on a problem of this dimension; raises BenchError where a table lacks it."""
    if isinstance(budget, int):
        return budget
    if isinstance(budget, str):
        return max(1, round(_multiple(budget) * dimension))
    if str(dimension) not in budget:
        dimensions = ", ".join(budget)
        raise BenchError(f"the budget has no evaluations for problems of dimension {dimension}; it has {dimensions}")
    return budget[str(dimension)]


def described(budget: Budget) -> str:
    """Return a budget in words, such as ``"10,000 d evaluations"``."""
    if isinstance(budget, int):
        return f"{budget:,} evaluation{'' if budget == 1 else 's'}"
    if isinstance(budget, str):
        return f"{_multiple(budget):,.10g} d evaluations"
    parts = [f"{number:,} evaluations at d = {dimension}" for dimension, number in budget.items()]
    return joined(parts)


def shortened(budget: Budget, share: int, least: int) -> Budget:
    """Return a budget of 1 / ``share`` of the evaluations, but not below ``least`` where the budget has as many."""
    if isinstance(budget, int):
        return max(min(budget, least), budget // share)
    if isinstance(budget, str):
        factor = _multiple(budget)
        return f"{max(min(factor, least), factor / share):g} * d"
    return {dimension: max(min(number, least), number // share) for dimension, number in budget.items()}


def _multiple(text: str) -> float:
    """Return the evaluations a dimension of a text such as ``"1e4 * d"``, 0 for another text."""
    match = _MULTIPLE.fullmatch(text)
    return float(match[1].replace("_", "")) if match else 0.0
