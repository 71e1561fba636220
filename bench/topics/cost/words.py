"""The sentences on what the optimizers cost."""

from __future__ import annotations

from collections.abc import Sequence

from bench.report.wording import listing, seconds

MOST = 5  # optimizers that a sentence names


def fastest(fast: str, least: float, slow: str, most: float) -> str:
    """Say whose median run takes the least and the most time."""
    if fast == slow:
        return f"A median run of {fast} takes {seconds(least)}."
    if seconds(least) == seconds(most):
        return f"A median run takes {seconds(least)}, whatever the optimizer."
    return f"A median run of {fast} takes {seconds(least)}, the least, and one of {slow} {seconds(most)}, the most."


def unknown(optimizers: Sequence[str]) -> str:
    """Say whose times are not known."""
    return f"No time of {listing(optimizers, at_most=MOST)} is known." if optimizers else ""


def note(memory: bool) -> str:
    """Say what the columns mean, and what the file has."""
    most = " MB: by how much the run that took most raised the peak of its process’s memory." * memory
    return f"Own: the wall time outside the objective.{most} The CSV file has quartiles and processor times."
