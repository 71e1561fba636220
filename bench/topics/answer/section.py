"""The first section of the page: who ends lowest, and how sure that is."""

from __future__ import annotations

from dataclasses import replace

from bench.report.parts import Section
from bench.topics.findings import Findings
from bench.topics.subject import section as subject
from bench.topics.verdict import section as verdict

TITLE = "Answer"


def section(findings: Findings) -> Section:
    """Return the answer, or a section that states why there is nothing to compare."""
    further = subject.section(findings)
    files = tuple(verdict.answer_file(findings))
    return replace(findings.of(verdict.section), title=TITLE, sections=(further,) if further else (), files=files)
