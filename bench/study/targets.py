"""The targets of a study: values that count as reached, from which running times and success rates follow."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from bench.errors import BenchError
from bench.numbers import is_finite

Targets = str | list[float] | list[str]
"""As a study holds them: a kind's name, falling precisions, or falling percentages of the optimum such as ``"5%"``."""

KINDS = {
    "precisions": "COCO's 51 precisions, the best value less the optimum, from 1e2 to 1e-8",
    "runlength": "the precisions that the best of 2009 reached next after 0.5, 1.2, 3, 10 and 50 d evaluations",
    "relative": "shares of the distance from each problem's first values to the optimum, from 1 to 1e-8",
    "quantiles": "quantiles of the best values of all trials on each problem",
    "tolerance": "multiples of the tolerance of an expected metric",
}
"""What the kinds of targets are measured by, by name."""

NO_METRIC = (
    "targets by tolerance need a problem with an expected metric, and this study has none; choose other targets, such "
    "as relative"
)
"""The message where no problem has an expected metric."""

MOST = 1000  # targets of a list

_PERCENT = re.compile(r"\s*([0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?)\s*%\s*", re.ASCII)


def checked(value: Any, what: str) -> Targets:
    """Return targets as a study holds them: each once, from the easiest to the hardest.

    Args:
        value: one of :data:`KINDS`; positive precisions; percentages of the optimum such as ``"1%"``; or a text of
            either, separated by commas.
        what: the subject of a sentence about it, such as ``"the targets"``.

    Raises:
        BenchError: for anything else.
    """
    if isinstance(value, str):
        if value.strip() in KINDS:
            return value.strip()
        parts: Sequence[Any] = [_number(part) for part in value.split(",")]
    else:
        parts = list(value) if isinstance(value, list | tuple) else []
    if 0 < len(parts) <= MOST:
        if all(isinstance(part, str) for part in parts):
            shares = [_share(part) for part in parts]
            if all(0 < share < math.inf for share in shares):
                return [f"{share:.12g}%" for share in sorted(set(shares), reverse=True)]
        elif all(is_finite(part) and part > 0 for part in parts):
            return sorted({float(part) for part in parts}, reverse=True)
    *kinds, last = map(repr, KINDS)
    raise BenchError(
        f"{what} must be {', '.join(kinds)} or {last}, up to {MOST:,} positive precisions such as [1e-1, 1e-3], or "
        f"percentages of the optimum such as ['5%', '1%'], not {value!r}"
    )


def percentages(targets: Targets) -> list[float]:
    """Return the shares of the optimum of a list of percentages, falling; empty for other targets."""
    return [] if isinstance(targets, str) else [_share(text) / 100 for text in targets if isinstance(text, str)]


def precisions(targets: Targets) -> list[float]:
    """Return the precisions of a list of them, falling; empty for other targets."""
    return [] if isinstance(targets, str) else [value for value in targets if not isinstance(value, str)]


def _share(text: str) -> float:
    match = _PERCENT.fullmatch(text)
    return float(match[1]) if match else math.nan


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
