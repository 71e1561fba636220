"""Section 4 of the page: what was reached when."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.course import words
from bench.topics.course.curves import ahead, compared, rivals
from bench.topics.course.figure import reached_figure
from bench.topics.course.times import files, times_figure
from bench.topics.findings import Findings

TITLE = "Over the budget"


def section(findings: Findings) -> Section | None:
    """Return the curves of targets reached, and on suites running times; None where no run left a trace."""
    if not findings.trials.traces or findings.of(compared).hits.empty:
        return None
    times = times_figure(findings)
    written = tuple(file for file in files(findings) if times is None or file.path != "tables/running-times.csv")
    return Section(TITLE, tuple(_text(findings)), tuple(filter(None, (reached_figure(findings), times))), files=written)


def _text(findings: Findings) -> list[str]:
    found, chosen = findings.of(compared), findings.anytime.target_set
    known = findings.anytime.targets.drop_duplicates("problem")["known"].astype(bool)
    text = []
    if found.banded and len(findings.trials.optimizers) > 1:
        text += _ahead(findings)
        if left := len(findings.trials.problems) - found.hits["problem"].nunique():
            text.append(words.left_out(left))
    return [*text, words.SMALLER, chosen.meaning(known.tolist())]


def _ahead(findings: Findings) -> list[str]:
    """Return who is ahead when, and whose curves cross."""
    shown, leader = findings.of(ahead), findings.leader
    if shown.empty:
        return [words.nobody(leader)]
    unit = "evaluations / d" if findings.of(compared).dimensions else "evaluations"
    behind = shown["second"].where(shown["ahead"] == leader, leader)
    spells = [
        f"{first} ahead of {other} from {_spent(begin)} to {_spent(end)}"
        for first, other, begin, end in zip(shown["ahead"], behind, shown["begin"], shown["end"], strict=True)
    ]
    crossed = [rival for rival in rivals(findings) if shown.loc[shown["second"] == rival, "ahead"].nunique() > 1]
    return [words.ahead(spells, unit), *([words.crossed(leader, crossed)] if crossed else [])]


def _spent(evaluations: float) -> str:
    """Return a number of evaluations in two digits, as the grid is no finer."""
    rounded = float(f"{evaluations:.2g}")
    return f"{rounded:,.0f}" if rounded >= 10 else f"{rounded:g}"
