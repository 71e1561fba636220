"""How folders differ that are compared though one of them was imported."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.findings import Findings

TITLE = "What is compared"


def section(findings: Findings) -> Section | None:
    """Return the differences in problems, dimensions, instances, trials and budgets; None where there are none."""
    sentences = findings.results.differences
    return Section(TITLE, tuple(sentences)) if sentences else None
