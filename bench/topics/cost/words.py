"""The sentences on what the optimizers cost."""

from __future__ import annotations

from collections.abc import Sequence

from bench.analysis.cells import CONTENTION, HIDDEN_THREADS
from bench.report.wording import listing, seconds

MOST = 5  # optimizers that a sentence names


def fastest(fast: str, least: float, slow: str, most: float) -> str:
    """Say whose run takes the least and the most time."""
    if fast == slow:
        return f"A run of {fast} takes {seconds(least)}."
    return f"A run of {fast} takes {seconds(least)}, the least, and one of {slow} {seconds(most)}, the most."


def unknown(optimizers: Sequence[str]) -> str:
    """Say whose times are not known."""
    return f"No time of {listing(optimizers, at_most=MOST)} is known." if optimizers else ""


def waited(optimizers: Sequence[str]) -> str:
    """Say whose trials waited for their core."""
    if not optimizers:
        return ""
    return (
        f"Trials of {listing(optimizers, at_most=MOST)} waited for a core: their wall time is more than "
        f"{CONTENTION:g} times their processor time. Trust processor times."
    )


def several_cores(optimizers: Sequence[str]) -> str:
    """Say whose trials used more than one core."""
    if not optimizers:
        return ""
    return (
        f"Trials of {listing(optimizers, at_most=MOST)} used more than one core: their processor time is more than "
        f"{HIDDEN_THREADS:g} times their wall time."
    )


def crowded() -> str:
    """Say that the machine was crowded."""
    return "More trials ran at a time than there were cores, so wall times are too long."
