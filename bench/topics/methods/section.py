"""The methods of this run as a paper describes them, its problems and conditions."""

from __future__ import annotations

from bench.report.parts import File, Section
from bench.topics.conditions.conditions import conditions_table
from bench.topics.findings import Findings
from bench.topics.hung import hung
from bench.topics.methods.methods import methods
from bench.topics.methods.problems import problems_table
from bench.topics.time import environment

TITLE = "Methods, environment, files"
DOI = (  # plainnat and elsarticle-num set a DOI as text, where "_" is an error, unless a package defines these
    r'@preamble{"\providecommand{\doi}[1]{\texttt{\detokenize{doi:#1}}}'
    r'\providecommand{\href}[2]{#2}\providecommand{\path}[1]{\texttt{\detokenize{#1}}}"}'
)

ABOUT = "The works cited in the methods; join the files of two studies such that each key stands there once."


def section(findings: Findings) -> Section | None:
    """Return the methods, the environment and the files."""
    return hung(findings, TITLE, paragraph, environment.section, files=(texts,))


def paragraph(findings: Findings) -> Section:
    """Return the paragraph that is true of this run, with the BibTeX of the works they cite."""
    if findings.trials.whole.empty:
        return Section("Methods", ("The study has no trial yet, so there are no methods to describe.",))
    stated = findings.of(methods)
    tables = (
        problems_table(findings.trials.known, findings.trials.pooled.members),
        conditions_table(findings.study, findings.descriptions),
    )
    return Section("Methods", (stated.text,), tables, stated.warnings, code=stated.bibtex)


def texts(findings: Findings) -> list[File]:
    """Return the methods as Markdown and LaTeX, and the works they cite; none without a trial."""
    if not len(findings.results.frame):
        return []
    stated = findings.of(methods)
    return [
        File("methods.md", "The methods as Markdown.", stated.markdown),
        File("methods.tex", "The methods as LaTeX.", stated.latex),
        File("references.bib", ABOUT, f"{DOI}\n\n{stated.bibtex}"),
    ]
