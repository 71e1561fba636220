"""The sentences of the answer: a headline of at most 25 words, and at most five short lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isinf

from bench.report.wording import count, listing, percent, seconds

NAMED = 2  # optimizers that a sentence names


def where(problems: Sequence[str]) -> str:
    """Return ``"on these 18 problems"``, or the name of the only one."""
    return f"on {problems[0]}" if len(problems) == 1 else f"on these {len(problems)} problems"


def winner(label: str, problems: Sequence[str], unlike: bool) -> str:
    """Return the headline of a study in which every test shows one optimizer to end lower."""
    return f"{label} ends lowest {where(problems)}{', under unlike conditions' * unlike}."


def no_winner(first: Sequence[str], undecided: Sequence[str], problems: Sequence[str], tested: bool) -> str:
    """Return the headline of a study without a winner."""
    if len(first) > 1:
        return f"No winner {where(problems)}: {listing(first, NAMED)} share the first place."
    if not tested:
        return f"No winner {where(problems)}: {first[0]} is first, and single runs cannot be tested."
    rivals = listing(undecided, NAMED)
    return f"No winner {where(problems)}: {first[0]} is first, but not shown to end lower than {rivals}."


def against(
    subject: str, better: Sequence[str], worse: Sequence[str], undecided: Sequence[str], problems: Sequence[str]
) -> str:
    """Return the headline of a study with a subject: whom it beats, loses to, and who is open."""
    every = len(better) + len(worse) + len(undecided)
    rivals = f"{len(better)} of {count(every, 'rival')}" if every > 1 else [*better, *worse, *undecided][0]
    if not better and not worse:
        whom = "any rival" if every > 1 else rivals
        return f"{subject} is shown neither better nor worse than {whom} {where(problems)}."
    parts = [f"beats {rivals}"] if better else []
    parts += [f"loses to {listing(worse, NAMED)}"] if worse else []
    parts += [f"is open against {listing(undecided, NAMED)}"] if undecided else []
    return f"{subject} {', '.join(parts)} {where(problems)}."


def first_on(number: int, problems: int) -> str:
    """Return on how many problems an optimizer has the highest chance to end lower."""
    return f"first on {number} of {count(problems, 'problem')}"


def lower_than_all(number: int) -> str:
    """Return on how many problems tests show an optimizer to end lower than every rival."""
    return f"lower than every rival by test on {number}"


def lower_than(rival: str, better: int, worse: int) -> str:
    """Return on how many problems tests show an optimizer to end lower than a rival, and higher."""
    return f"against {rival}: lower on {better}, higher on {worse}"


def not_in(dimensions: Mapping[str, str]) -> str:
    """Return in which dimensions another optimizer is first."""
    if len(dimensions) > NAMED:
        return f"another is first in {len(dimensions)} dimensions"
    return listing([f"{label} is first in dimension {dimension}" for dimension, label in dimensions.items()])


def chance(label: str, rival: str, share: float, low: float, high: float, second: bool) -> str:
    """Return how often a run of one optimizer ends lower than a run of another, with its interval."""
    ends = "" if low != low else f" [{100 * low:.0f}, {100 * high:.0f}]"
    rank = ", the second," if second else ""
    return f"a run of {label} ends lower than one of {rival}{rank} in {percent(share)}{ends} of pairs"


def as_many(target: str, ratios: Sequence[tuple[str, float, float, float]]) -> str:
    """Return how many times as many evaluations rivals need to a target, with intervals, which may have an open end."""
    parts = []
    for rival, ratio, low, high in ratios:
        ends = f"at least {low:.2g}" if isinf(high) else f"{ratio:.2g} [{low:.2g}, {high:.2g}]"
        parts.append(f"{rival} needs {ends if low else f'at most {high:.2g}'}")
    return f"{listing(parts)} times as many evaluations to {target}"


def sure(subject: bool, problems: int) -> str:
    """Return the chance of a wrong claim over these problems."""
    claim = "a wrong claim against any rival" if subject else "a wrong winner"
    return f"{claim} has a chance of at most 5%, {'for this problem' if problems == 1 else 'for these problems'} only"


def chance_order() -> str:
    """Return what holds where nothing is tested."""
    return "the order may be chance: a cell with one run leaves nothing to test"


def changed(made: Sequence[str], seed: int) -> str:
    """Return what was changed after the results, in place of the chance of a wrong claim."""
    return f"changed after the results: {listing(made, NAMED)}; run again with another seed: bench run … --seed {seed}"


def not_known() -> str:
    """Return the clause on a folder without a history."""
    return "changes after the results are not known"


def own_time(label: str, own: float, rival: str, other: float) -> str:
    """Return the time that a run takes besides the problem's own, beside that of a rival."""
    return f"on average, {label} takes {seconds(own)} of its own a run, {rival} {seconds(other)}"
