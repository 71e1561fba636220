"""Sweeps: an optimizer with several values of its parameters, one labelled optimizer for each combination.

The label of a combination names its values, as in ``gwo[agents=30,variant=code]``, and is all that marks it as a part
of a sweep: a frozen study, and results that were exported and read again, need no other record.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from math import prod

from bench.contract.typing import Options
from bench.helpers.errors import BenchError
from bench.helpers.text import option

MOST = 1_000
"""The largest number of combinations of one sweep: each is an optimizer of the study."""


def expanded(label: str, fixed: Options, options: Options) -> list[tuple[str, Options]]:
    """Return label and options of each combination of the values that ``options`` lists; those of ``fixed`` are kept.

    The last list varies fastest. A value that is no list is the same in all combinations and no part of the label.

    Raises:
        BenchError: for an empty list, a value twice, and more than 1,000 combinations.
    """
    swept = {name: value for name, value in options.items() if isinstance(value, list)}
    for name, values in swept.items():
        texts = [option(value) for value in values]
        if not texts or len(set(texts)) < len(texts):
            what = "is empty" if not texts else "holds a value twice"
            raise BenchError(f"the list of values of {name!r} of {label!r} {what}; list each value once")
    if (number := prod(map(len, swept.values()))) > MOST:
        raise BenchError(f"the sweep of {label!r} has {number:,} combinations, more than {MOST:,}; list fewer values")
    kept = {**fixed, **{name: value for name, value in options.items() if name not in swept}}
    combinations = []
    for combination in product(*swept.values()):
        chosen = dict(zip(swept, combination, strict=True))
        pairs = [(name, option(value)) for name, value in chosen.items()]
        combinations.append((_label(label, pairs) if chosen else label, kept | chosen))
    return combinations


def swept(label: str, options: Options) -> tuple[str, tuple[str, ...]]:
    """Return the name before the bracket of a combination's label, and the parameters in it; none of other labels.

    The bracket holds the last of the optimizer's own options. Combinations of one sweep have both in common.
    """
    pairs = [(name, option(value)) for name, value in options.items()]
    for first in range(len(pairs)):
        bracket = _label("", pairs[first:])
        if label.endswith(bracket) and label != bracket:
            return label.removesuffix(bracket), tuple(name for name, _ in pairs[first:])
    return label, ()


def _label(name: str, pairs: Iterable[tuple[str, str]]) -> str:
    return f"{name}[{','.join(f'{parameter}={value}' for parameter, value in pairs)}]"
