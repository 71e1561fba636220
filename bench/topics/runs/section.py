"""Section 3 of the page: every run of every optimizer on every problem."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.findings import Findings
from bench.topics.runs import words
from bench.topics.runs.figure import runs_figure
from bench.topics.runs.tables import comparison, files

TITLE = "Every run"


def section(findings: Findings) -> Section | None:
    """Return the figure of all runs, and behind it the table of medians; None without a run."""
    if not findings.trials.problems:
        return None
    figure = runs_figure(findings, comparison(findings))
    tests = findings.final.pairs
    tests = tests[tests["p_holm"].notna()]
    tested, shown = (each["problem"].nunique() for each in (tests, tests[tests["lower"] != ""]))
    text = (words.differences(tested, shown),) if tested else ()
    return Section(TITLE, text, (figure,), files=files(findings))
