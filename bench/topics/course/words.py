"""The sentences of the section on the course over the budget."""

from __future__ import annotations

from collections.abc import Sequence

from bench.report.wording import count, listing

SMALLER = "Values at smaller budgets are those of runs that were planned for the full budget."


def ahead(spells: Sequence[str], unit: str) -> str:
    """Return when who is shown to be ahead; spells are texts such as "A ahead of B from 100 to 2,000"."""
    more = f" The strip below the curves has {len(spells) - 2} more." if len(spells) > 2 else ""
    return f"In {unit}, the bands show {listing(list(spells[:2]))}.{more}"


def nobody(leader: str) -> str:
    """Return that no band shows the leader to be ahead of a rival, or behind."""
    return f"At no budget do the bands show {leader} ahead of a rival, or behind one."


def crossed(leader: str, rivals: Sequence[str]) -> str:
    """Return whose curves cross."""
    return f"The curve of {leader} crosses that of {listing(list(rivals), at_most=4)}: who leads depends on the budget."


def left_out(problems: int) -> str:
    """Return how many problems the curves leave out."""
    return f"The curves leave out {count(problems, 'problem')} on which an optimizer has fewer than two runs."


def caption(leader: str, unit: str, banded: bool, drawn: int, optimizers: int) -> str:
    """Return the caption of the curves of targets reached."""
    some = f" The first {drawn} of {optimizers} optimizers." if drawn < optimizers else ""
    if not banded:
        return f"The share of targets reached over {unit}, the mean over problems of the mean over runs.{some}"
    return (
        f"Above: the share of targets reached over {unit}, the mean over problems of the mean over runs. Bands hold "
        f"at all budgets together (95%), for new runs on these problems.{some} Below: when {leader} or the rival is "
        "shown to be ahead, in the colour of who is."
    )


def times_caption(dimension: str, unit: str) -> str:
    """Return the caption of the running times by function and target."""
    return (
        f"Expected running time (ERT) in evaluations, by function and {unit}{dimension}, harder targets to the right. "
        "A curve ends at the hardest target that a run reached; its end is open where harder ones follow."
    )


def times_note(divisor: str, level: str, stars: bool) -> str:
    """Return the note below the table of running times."""
    return (
        f"ERT over {divisor}, to {level}. ∞: no run reached it, with the successes. Bold: the lowest of the row."
        + (" *: shown faster than every other one (A12, p < 0.05 by Holm’s method over the rows)." if stars else "")
        + " The CSV file has every target, intervals, and times in seconds."
    )
