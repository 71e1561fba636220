"""The section of the page on the outcome in the units of the problems."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.competition import section as competition
from bench.topics.findings import Findings
from bench.topics.hung import hung

TITLE = "In your units"


def section(findings: Findings) -> Section | None:
    """Return the section; None where there is no finding."""
    return hung(findings, TITLE, competition.section)
