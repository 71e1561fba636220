"""What an optimizer may favour by itself, which ``bench check`` looks for, and how a report tells of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


def percent(share: float) -> str:
    """Return a share as a percentage of three digits."""
    return f"{100 * share:.3g}%"


class Trait(NamedTuple):
    """How a trait that ``bench check`` looks for is told: of those who have it, of its figures, and where none has it.

    ``figure`` spells the figure that an optimizer was judged by.
    """

    trouble: str
    meaning: str
    figure: Callable[[float], str]
    well: str


TRAITS = {
    "centre bias": Trait(  # Kudela 2022
        "Errors are higher when the optimum is moved away from the centre of the box",
        "Results on problems with a central optimum flatter these.",
        lambda ratio: f"{ratio:.2g} times",
        "does better where the optimum is at the centre",
    ),
    "structural bias": Trait(  # Kononova et al. 2015
        "On pure noise, where no point is better than another, the best points are not uniform in the box",
        "Results depend on where in the box the optimum lies.",
        lambda p: f"p = {p:.1g}",
        "favours a part of the box on pure noise",
    ),
    "boundary clamping": Trait(
        "Best points have coordinates on a bound of the box where no optimum lies there",
        "Results on problems with an optimum on a bound flatter these.",
        lambda share: f"{percent(share)} of them",
        "is drawn to the bounds of the box",
    ),
    "starts and seeds": Trait(
        "Runs start elsewhere than uniformly and independently in the box, or are the same with another seed",
        "Trials may not be independent.",
        lambda p: f"p = {p:.1g}",
        "repeats a run with another seed or favours a part of the box at the start",
    ),
}
