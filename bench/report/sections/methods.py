"""The methods section of a paper about this run."""

from __future__ import annotations

from bench.report.findings import Findings
from bench.report.parts import Section

TITLE = "Methods"


def section(findings: Findings) -> Section:
    """Return the methods as paragraphs that are true of this run, with the BibTeX of the works they cite."""
    if findings.frame.empty:
        return Section(TITLE, ("No trial was made yet, so there are no methods to describe.",))
    made = findings.methods
    return Section(TITLE, made.text, warnings=made.warnings, code=made.bibtex)
