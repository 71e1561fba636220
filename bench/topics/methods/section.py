"""The methods of this run as a paper describes them, its environment, and the files of the report."""

from __future__ import annotations

from collections.abc import Iterator

from bench.analysis.customary import customary, friedman
from bench.report.parts import File, Section, warning
from bench.topics.conditions.conditions import conditions_table
from bench.topics.findings import Findings
from bench.topics.methods.environment import Environments
from bench.topics.methods.methods import methods
from bench.topics.methods.problems import bounds

TITLE = "Methods, environment, files"
DOI = (  # plainnat and elsarticle-num set a DOI as text, where "_" is an error, unless a package defines these
    r'@preamble{"\providecommand{\doi}[1]{\texttt{\detokenize{doi:#1}}}'
    r'\providecommand{\href}[2]{#2}\providecommand{\path}[1]{\texttt{\detokenize{#1}}}"}'
)

ABOUT = "The works cited in the methods; join the files of two studies such that each key stands there once."
CUSTOMARY = "The tests that reviewers ask for; the page claims nothing by them."


def section(findings: Findings) -> Section:
    """Return the paragraph that is true of this run, the environment and the list of all files."""
    environments = Environments(findings.results)
    tables = (environments.table(),) if environments.records else ()
    if findings.trials.whole.empty:
        text = ("The study has no trial yet, so there are no methods to describe.",)
        return Section(TITLE, text, tables, lists_files=True)
    stated = findings.of(methods)
    written = (*texts(findings), *frames(findings), *environments.files())
    lines = tuple(warning("not cited", text) for text in stated.warnings)
    return Section(TITLE, (stated.text,), tables, lines=lines, files=written, lists_files=True)


def texts(findings: Findings) -> Iterator[File]:
    """Yield the methods as Markdown and LaTeX, and the works they cite."""
    stated = findings.of(methods)
    yield File("methods.md", "The methods as Markdown.", stated.markdown)
    yield File("methods.tex", "The methods as LaTeX.", stated.latex)
    yield File("references.bib", ABOUT, f"{DOI}\n\n{stated.bibtex}")


def frames(findings: Findings) -> Iterator[File]:
    """Yield the files of the problems, the conditions, and the customary tests."""
    conditions = conditions_table(findings.study, findings.descriptions)
    yield File("tables/problems.csv", "Bounds and optima of the problems.", bounds(findings.trials.known))
    yield File("tables/conditions.csv", conditions.caption, conditions.frame.reset_index())
    if len(findings.trials.optimizers) > 1:
        tests = customary(findings.trials.frame, findings.leader)
        yield File("tables/customary.csv", f"{CUSTOMARY} {friedman(findings.trials.frame)}", tests)
