"""The answer of a report in a few lines: the verdict's first sentence and a short table, for a terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from bench.helpers.parsing import parse_json, read_text
from bench.plots import style
from bench.report.findings import Findings
from bench.report.parts import Section
from bench.report.wording import count, percent

NOTE = "answer.json"
MOST = 12  # optimizers in the table
LONGEST = 36  # letters of an optimizer's name


def answer(findings: Findings, verdict: Section) -> dict[str, Any]:
    """Return what the terminal shows of a report, as JSON holds it.

    Args:
        findings: of the report.
        verdict: its first section, whose first sentence is shown.
    """
    sentences = [*(text for card in verdict.cards for text in card.text), *verdict.text, *verdict.warnings]
    rows: list[list[str]] = []
    if verdict.cards:
        ranking = findings.final.ranking.set_index("optimizer").to_dict("index")
        for label in findings.final.ranked[:MOST]:
            row = ranking[label]
            first = f"{row['first']:g} of {row['problems']:g}"
            name = style.plain(label, LONGEST).replace(r"\$", "$")
            rows.append([name, f"{row['mean_rank']:.2f}", first, percent(findings.anytime.near_best[label])])
    more = len(findings.trials.optimizers) - len(rows) if rows else 0
    return {
        "sentence": sentences[0] if sentences else "",
        "columns": ["optimizer", "mean rank", "first on", findings.anytime.near_words],
        "rows": rows,
        "more": f"and {count(more, 'other optimizer')}" if more else "",
        "trials": len(findings.results.frame),
    }


def read(folder: Path) -> dict[str, Any]:
    """Return the answer of the report in a folder; empty where there is none that can be read."""
    try:
        content = parse_json(read_text(folder / NOTE))
        return content if isinstance(content, dict) and isinstance(content.get("rows"), list) else {}
    except (OSError, ValueError):
        return {}


def shown(content: dict[str, Any]) -> Group:
    """Return an answer as lines for a terminal."""
    parts: list[RenderableType] = [Text(str(content.get("sentence", "")), style="bold")]
    if content["rows"]:
        first, *heads = map(str, content["columns"])
        table = Table(first, box=None, pad_edge=False)
        for head in heads:
            table.add_column(head, justify="right")
        for row in content["rows"]:
            table.add_row(*(Text(str(cell)) for cell in row))
        parts += [Text(), table]
    if content.get("more"):
        parts.append(Text(str(content["more"])))
    return Group(*parts)
