"""Section 3 of the page: every run of every optimizer on every problem."""

from __future__ import annotations

import pandas as pd

from bench.analysis.best import best
from bench.helpers.text import listed
from bench.report.parts import File, Section, Table
from bench.topics.findings import Findings
from bench.topics.runs import words
from bench.topics.runs.figure import runs_figure
from bench.topics.runs.tables import comparison, files

TITLE = "Every run"
ROWS, MOST = 20, 10  # problems whose best points the page shows, and coordinates of a point


def section(findings: Findings) -> Section | None:
    """Return the figure of all runs, and behind it the table of medians; None without a run."""
    if not findings.trials.problems:
        return None
    figure = runs_figure(findings, comparison(findings))
    tests = findings.final.pairs
    tests = tests[tests["p_holm"].notna()]
    tested, shown = (each["problem"].nunique() for each in (tests, tests[tests["lower"] != ""]))
    text = (words.differences(tested, shown),) if tested else ()
    table = best_points(findings)
    if 0 < len(table.frame) <= ROWS:
        return Section(TITLE, text, (figure, table), files=files(findings))
    every = (File(f"tables/{table.name}.csv", table.caption, table.data),) if table.data is not None else ()
    return Section(TITLE, text, (figure,), files=(*files(findings), *every))


def best_points(findings: Findings) -> Table:
    """Return the best point of each problem, with the run that found it."""
    found = best(findings.results.frame)
    named = [[f"{name} = {value:.6g}" for name, value in each.point.items()] for each in found]
    rows = pd.DataFrame([each[:4] for each in found], columns=["problem", "value", "optimizer", "trial"])
    points = pd.DataFrame([{f"x_{name}": value for name, value in each.point.items()} for each in found])
    shown = rows.assign(point=[listed(each, MOST) for each in named])
    return Table("best-points", words.BEST, shown, data=rows.join(points))
