"""The methods of this run as a paper describes them."""

from __future__ import annotations

from bench.report.conditions import conditions_table
from bench.report.findings import Findings
from bench.report.methods import methods
from bench.report.parts import Section
from bench.report.problem_words import problems_table

TITLE = "Methods"


def section(findings: Findings) -> Section:
    """Return paragraphs that are true of this run, with the BibTeX of the works they cite."""
    if findings.trials.whole.empty:
        return Section(TITLE, ("The study has no trial yet, so there are no methods to describe.",))
    texts = methods(findings)
    tables = (
        problems_table(findings.trials.known, findings.trials.pooled.members),
        conditions_table(findings.study, findings.descriptions),
    )
    return Section(TITLE, texts.text, tables, texts.warnings, code=texts.bibtex)
