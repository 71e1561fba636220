"""The section of the page on what was reached when."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.anytime import best, logged
from bench.topics.anytime import section as anytime
from bench.topics.findings import Findings
from bench.topics.hung import hung
from bench.topics.suite import section as suite

TITLE = "Over the budget"


def section(findings: Findings) -> Section | None:
    """Return the section; None where there is no finding."""
    return hung(findings, TITLE, anytime.section, suite.section, logged.section, best.section, files=(anytime.tables,))
