"""The section of the page on what the optimizers cost."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.findings import Findings
from bench.topics.hung import hung
from bench.topics.time import section as time

TITLE = "Cost"


def section(findings: Findings) -> Section | None:
    """Return the section; None where there is no finding."""
    return hung(findings, TITLE, time.section)
