"""The sentences on backlash."""

from __future__ import annotations

from collections.abc import Sequence

from bench.report import count, listing

MOST = 5  # optimizers that a sentence names


def remembered(shares: Sequence[tuple[str, float]]) -> str:
    """Say in how many per cent of their runs the first optimizers found the best fit."""
    (first, share), *others = shares
    beside = "".join(f", {label} {other:.0f}%" for label, other in others)
    return f"{first} finds the best fit in {share:.0f}% of its runs{beside}"


def unknown(problems: str, reason: str) -> str:
    """Say whose true values are not known."""
    return f"The expected values of {problems} are not known here and left out: {reason}."


def best_fit(shares: Sequence[str], near: float) -> str:
    """Say which share of the runs ended at the best fit."""
    ended = listing(shares, at_most=MOST)
    return f"{ended} ended within {near:.0%} of the best fit, which is computed without an optimizer."


def constraints(limited: Sequence[str], raised: int, most: float, datasets: int) -> str:
    """Say what the constraints cost the best fit."""
    cost = f"raise the best error on {raised} of {datasets} datasets, by {most:.1%} at most" if raised else (
        f"do not raise the best error on any of {count(datasets, 'dataset')}"
    )  # fmt: skip
    return f"The constraints of section 7.2.2, under which {listing(limited, at_most=MOST)} ran, {cost}."


def within(what: str, shares: Sequence[str], band: str) -> str:
    """Say which share of the runs found a value within its band."""
    return f"{listing(shares, at_most=MOST)} found the {what} within {band}."


def order(names: Sequence[str], held: int, rows: int, published: int) -> str:
    """Say in how many rows of Table 7.2 the published order holds."""
    ranked = " < ".join(name.upper() for name in names)
    return f"The order {ranked} holds in {held} of {rows} rows of Table 7.2, and in {published} of the printed ones."


def too_few(trials: int) -> str:
    """Say that no test of so few trials can reject."""
    return f"With {count(trials, 'trial')} a cell no Kolmogorov-Smirnov test can distinguish two swarms."


def distinguished(alpha: float, apart: int, pairs: int) -> str:
    """Say how many pairs of swarms a test distinguishes; the thesis distinguishes most."""
    return (
        f"A Kolmogorov-Smirnov test at {alpha:g}, unadjusted as in the thesis, distinguishes {apart} of "
        f"{count(pairs, 'pair')} of swarms; the thesis distinguishes most."
    )
