"""The sentences on the table of a competition."""

from __future__ import annotations

from bench.analysis.direction import ALPHA
from bench.analysis.instances import SOLVED
from bench.report.wording import count

NOTE = "Bold: the lowest mean of a row. ∞: a trial failed. The CSV file has best, worst and median, too."


def caption(common: str, without: int) -> str:
    """Say what an error is; ``without`` counts the problems that have no optimum, or a beaten one."""
    at = f" {common}" if common else ""
    values = f" Of {count(without, 'problem')} without a known optimum it is the value." if without else ""
    return f"Mean and SD of the error{at}: the best value less the optimum, 0 from {SOLVED:g} on.{values}"


def signs(subject: str, tests: int) -> str:
    """Say what the signs mean, at which level, and how many would appear without any difference."""
    return (
        f"+: a run of {subject} is shown to end lower more often than one of this column (A12, p < {ALPHA:g}); −: less "
        f"often; ≈: neither. Nothing is adjusted: of {count(tests, 'test')} without any difference, about "
        f"{ALPHA * tests:.2g} would show a sign."
    )
