"""The section of the page on what may limit the answer."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.findings import Findings
from bench.topics.hung import hung
from bench.topics.integrity import beside
from bench.topics.integrity import section as integrity

TITLE = "Can you trust it?"


def section(findings: Findings) -> Section | None:
    """Return the section; None where there is no finding."""
    return hung(findings, TITLE, beside.section, integrity.section)
