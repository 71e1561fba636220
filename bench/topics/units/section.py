"""The section of the page on the outcome in the units of the problems: here the competition's table."""

from __future__ import annotations

from bench.report.parts import Section
from bench.topics.findings import Findings
from bench.topics.units.competition import files, table

TITLE = "In your units"


def section(findings: Findings) -> Section | None:
    """Return the table of a competition, where the study has one; families of problems add parts of their own."""
    made = table(findings)
    return None if made is None else Section(TITLE, items=(made,), files=tuple(files(findings)))
