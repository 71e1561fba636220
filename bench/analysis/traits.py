"""The traits of optimizers that ``bench check`` looks for, and the sentences of a report on them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


def percent(share: float) -> str:
    """Return a share as a percentage of three digits."""
    return f"{100 * share:.3g}%"


class Trait(NamedTuple):
    """The parts of a report's sentence on a trait.

    Attributes:
        trouble: what was observed of the optimizers that have the trait.
        meaning: the consequence for conclusions.
        shown: formats the number that decided about an optimizer.
        well: what no optimizer does where none has the trait.
    """

    trouble: str
    meaning: str
    shown: Callable[[float], str]
    well: str


TRAITS = {
    "centre bias": Trait(  # Kudela 2022
        "Errors are higher when the optimum is moved away from the centre of the box",
        "Results on problems with a central optimum flatter these optimizers.",
        lambda ratio: f"{ratio:.2g} times",
        "is better where the optimum is at the centre",
    ),
    "structural bias": Trait(  # Kononova et al. 2015
        "On pure noise, where no point is better than another, the best points are not uniform in the box",
        "Results depend on where in the box the optimum lies.",
        lambda p: f"p = {p:.1g}",
        "favours a part of the box on pure noise",
    ),
    "boundary clamping": Trait(
        "Best points have coordinates on a bound of the box where no optimum lies there",
        "Results on problems with an optimum on a bound flatter these optimizers.",
        lambda share: f"{percent(share)} of them",
        "is drawn to the bounds of the box",
    ),
    "starts and seeds": Trait(
        "Starting points are not uniform and independent in the box, or runs with different seeds are equal",
        "Trials may not be independent.",
        lambda p: f"p = {p:.1g}",
        "repeats a run with another seed or starts elsewhere than uniformly in the box",
    ),
}
