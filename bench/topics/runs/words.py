"""The sentences of the section on every run."""

from __future__ import annotations

from bench.report.wording import count

BEST = "The best point of each problem, and the run that found it. The CSV file has every digit."


def caption(axis: str, drawn: int, optimizers: int, marked: bool) -> str:
    """Return the caption of the figure of all runs."""
    some = f" The first {drawn} of {optimizers} optimizers by the chance to end lower." if drawn < optimizers else ""
    signs = " 1: the highest chance to end lower on the panel; ≈: no test separates it from that one." if marked else ""
    return (
        f"Every run is a dot, the line its median; lower is better, further left.{some} {axis}{signs} "
        "Beside ✗: the failed runs of an optimizer."
    )


def differences(problems: int, found: int) -> str:
    """Return on how many problems a test finds any difference, and on how many it would without one."""
    by_chance = problems / 20
    return (
        f"Tests find a difference on {found} of {count(problems, 'problem')}; of {problems} problems without any "
        f"difference, {by_chance:g} would show one."
    )


def table_note(leader: str, subject: bool, precise: bool) -> str:
    """Return the note below the table of medians."""
    values = " Values are precisions where instances are pooled." if precise else ""
    whom = f"{leader}'s tests alone are claims. " if subject else ""
    return (
        f"Bold: the highest chance to end lower. Raised: the chance (A12) that a run of {leader} ends lower; *: the "
        f"test shows a difference (Holm within the problem). {whom}–: no run; ∞: the median run failed.{values} "
        "The CSV file has means, p-values and all optimizers."
    )
