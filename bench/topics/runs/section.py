"""The section of the page on all final values."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.comparison import section as comparison
from bench.topics.datasets import section as datasets
from bench.topics.findings import Findings
from bench.topics.hung import hung
from bench.topics.ranks import section as ranks

TITLE = "Every run"


def section(findings: Findings) -> Section | None:
    """Return the section; None where there is no finding."""
    return hung(findings, TITLE, comparison.section, ranks.section, datasets.section, files=(comparison.tables,))
