"""The answer of a report in a few lines, as JSON holds it; :mod:`bench.cli.answer` shows it in a terminal."""

from __future__ import annotations

from typing import Any

from bench.plots import style
from bench.report.parts import Section
from bench.report.wording import count, percent
from bench.topics.findings import Findings

MOST = 12  # optimizers in the table
LONGEST = 36  # letters of an optimizer's name


def answer(findings: Findings, verdict: Section) -> dict[str, Any]:
    """Return the answer of a report that the terminal shows, as JSON holds it.

    Args:
        findings: of the report.
        verdict: its first section, whose first sentence is shown.
    """
    sentences = [*(text for card in verdict.cards for text in card.text), *verdict.text, *verdict.warnings]
    rows: list[list[str]] = []
    if verdict.cards:
        ranking = findings.final.ranking.set_index("optimizer").to_dict("index")
        names = style.names(findings.final.ranked[:MOST], LONGEST)
        for label, short in names.items():
            row = ranking[label]
            first = f"{row['first']:g} of {row['problems']:g}"
            rows.append(
                [
                    short.replace(r"\$", "$"),
                    f"{row['mean_rank']:.2f}",
                    first,
                    percent(findings.anytime.near_best[label]),
                ]
            )
    more = len(findings.trials.optimizers) - len(rows) if rows else 0
    return {
        "sentence": sentences[0] if sentences else "",
        "selection": findings.selection,
        "columns": ["optimizer", "mean rank", "first on", findings.anytime.near_words],
        "rows": rows,
        "more": f"and {count(more, 'other optimizer')}" if more else "",
        "trials": len(findings.results.frame),
    }
