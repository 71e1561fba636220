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
    return Section(TITLE, tuple(filter(None, _text(findings))), (figure,), files=files(findings))


def _text(findings: Findings) -> list[str]:
    tests, trials = findings.final.on_problems, findings.trials
    tests = tests[tests["p_holm"].notna()]
    text = []
    if tests["problem"].nunique():
        text.append(words.differences(tests["problem"].nunique(), tests.loc[tests["lower"] != "", "problem"].nunique()))
    empty = trials.coverage[trials.coverage["stored"] == 0]
    if gaps := empty.loc[empty["problem"].isin(trials.problems), "problem"].nunique():
        text.append(words.gaps(gaps))
    cells = trials.feasible
    if len(cells) and (lost := int((cells["trials"] - cells["feasible"]).sum())):
        text.append(words.infeasible(lost, int(cells["trials"].sum()), findings.study.constraints))
    return text
