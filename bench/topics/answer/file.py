"""The answer of a report in a few lines, as JSON holds it; :mod:`bench.cli.answer` shows it in a terminal."""

from __future__ import annotations

import json
from collections.abc import Iterable

from bench.helpers.parsing import JsonObject
from bench.plots import style
from bench.report.parts import File, Line, Section
from bench.report.wording import count, percent
from bench.storage.folder import ANSWER
from bench.topics.answer.section import headline, nothing_to_compare
from bench.topics.findings import Findings

MOST = 12  # optimizers in the table
LONGEST = 36  # letters of an optimizer's name


def answer_file(findings: Findings, first: Section) -> File:
    """Return the answer as a file, with the lines of the first section as the page shows it."""
    content = answer(findings, first.lines)
    return File(ANSWER, "The answer in a few lines, as JSON.", json.dumps(content, ensure_ascii=False, indent=1))


def answer(findings: Findings, lines: Iterable[Line]) -> JsonObject:
    """Return the answer of a report that the terminal shows, as JSON holds it: headline, lines, and a short table."""
    nothing = nothing_to_compare(findings)
    rows: list[list[str]] = []
    if not nothing:
        order = findings.final.order.set_index("optimizer").to_dict("index")
        for label, short in style.names(findings.final.ranked[:MOST], LONGEST).items():
            row = order[label]
            rows.append(
                [
                    short.replace(r"\$", "$"),
                    f"{row['chance']:.2f}",
                    f"{row['first']} of {row['problems']}",
                    percent(findings.anytime.near_best[label]),
                ]
            )
    more = len(findings.trials.optimizers) - len(rows) if rows else 0
    return {
        "sentence": nothing or headline(findings),
        "lines": [[line.label, line.text] for line in lines],
        "selection": findings.selection,
        "columns": ["optimizer", "chance", "first on", findings.anytime.near_words],
        "rows": rows,
        "more": f"and {count(more, 'other optimizer')}" if more else "",
        "state": findings.state,
    }
