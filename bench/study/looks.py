"""The declared looks of a study: the numbers of trials at which a run compares the optimizers and may stop cells."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from bench.errors import BenchError, nearest
from bench.numbers import MOST_TRIALS, is_whole

Looks = tuple[int, ...]

EXAMPLE = "as in [looks] trials = [10, 20, 30]"
LEAST = 6  # trials: with fewer not even complete separation has a p of at most 0.05


def checked(value: Any, what: str) -> Looks:
    """Return looks as a study holds them: two or more increasing numbers of trials.

    Args:
        value: a table with a list ``trials``, as in a study's file, or the list alone.
        what: the subject of a sentence about them, such as ``"'looks'"``.

    Raises:
        BenchError: for anything else.
    """
    if isinstance(value, Mapping):
        for key in value:
            if key != "trials":
                raise BenchError(
                    f"{what} has an unknown key {key!r}{nearest(str(key), ['trials'])}; it has trials alone"
                )
        value = value.get("trials")
    if not isinstance(value, list | tuple) or not all(map(is_whole, value)):
        raise BenchError(f"{what} must be a list of numbers of trials, {EXAMPLE}, not {value!r}")
    looks = tuple(map(int, value))
    if len(looks) < 2:
        raise BenchError(f"{what} must be two or more, {EXAMPLE}; a single look at the end needs no declaration")
    if max(looks) > MOST_TRIALS:
        raise BenchError(f"{what} must be at most {MOST_TRIALS:,} trials, not {max(looks)}")
    if not all(one < following for one, following in pairwise(looks)):
        raise BenchError(f"{what} must increase, {EXAMPLE}, not {list(looks)}")
    if looks[0] < LEAST:
        raise BenchError(
            f"{what} must begin with {LEAST} trials or more, not {looks[0]}: no test of fewer can be significant"
        )
    return looks
